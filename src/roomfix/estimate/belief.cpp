#include "roomfix/estimate/belief.hpp"

#include <cmath>

namespace roomfix {
namespace {

void remove_state(Belief& belief, int index) {
    const int last = belief.size - 1;
    for (int i = index; i < last; ++i) {
        belief.mean[i] = belief.mean[i + 1];
        belief.slow[static_cast<std::size_t>(i - core_states)] = belief.slow[static_cast<std::size_t>(i - core_states + 1)];
    }
    auto& p = belief.covariance;
    for (int i = index; i < last; ++i) p.row(i).head(belief.size) = p.row(i + 1).head(belief.size).eval();
    for (int i = index; i < last; ++i) p.col(i).head(belief.size) = p.col(i + 1).head(belief.size).eval();
    FixedList<SlowState, most_slow_states> kept;
    for (std::size_t i = 0; i + 1 < belief.slow.size(); ++i) kept.push_back(belief.slow[i]);
    belief.slow = kept;
    belief.size = last;
}

/// The slow state that would be missed least.
int least_informed(const Belief& belief) {
    int least = core_states;
    double most_left = -1;
    for (int i = core_states; i < belief.size; ++i) {
        const double left = belief.covariance(i, i) / belief.slow[static_cast<std::size_t>(i - core_states)].variance;
        if (left > most_left) {
            most_left = left;
            least = i;
        }
    }
    return least;
}

}  // namespace

Belief belief_at(const Pose2& pose, const Eigen::Matrix3d& covariance, double speed_sigma, double turn_sigma, const OdometryPrior& prior) {
    Belief belief;
    belief.mean.head<3>() = Eigen::Vector3d(pose.x, pose.y, pose.yaw);
    belief.covariance.topLeftCorner<3, 3>() = covariance;
    belief.covariance(state_vx, state_vx) = belief.covariance(state_vy, state_vy) = speed_sigma * speed_sigma;
    belief.covariance(state_turn, state_turn) = turn_sigma * turn_sigma;
    belief.covariance(state_scale, state_scale) = prior.scale_sigma * prior.scale_sigma;
    belief.covariance(state_turn_scale, state_turn_scale) = prior.turn_scale_sigma * prior.turn_scale_sigma;
    belief.covariance(state_drift, state_drift) = prior.drift_sigma * prior.drift_sigma;
    return belief;
}

std::optional<int> find_slow(const Belief& belief, SlowKind kind, int source, int component) {
    for (std::size_t i = 0; i < belief.slow.size(); ++i) {
        const SlowState& s = belief.slow[i];
        if (s.kind == kind && s.source == source && s.component == component) return core_states + static_cast<int>(i);
    }
    return std::nullopt;
}

int ensure_slow(Belief& belief, const SlowState& state) {
    if (const auto index = find_slow(belief, state.kind, state.source, state.component)) return *index;
    if (belief.size == most_states) remove_state(belief, least_informed(belief));
    const int index = belief.size++;
    belief.slow.push_back(state);
    belief.mean[index] = 0;
    belief.covariance.row(index).head(belief.size).setZero();
    belief.covariance.col(index).head(belief.size).setZero();
    belief.covariance(index, index) = state.variance;
    return index;
}

double worst_sigma(const Eigen::Matrix2d& covariance) {
    const double mean = 0.5 * covariance.trace();
    const double half = std::sqrt(std::max(mean * mean - covariance.determinant(), 0.0));
    return std::sqrt(mean + half);
}

void forget_slow(Belief& belief, double seconds, double metres) {
    StateVector keep;
    keep.head(core_states).setOnes();
    bool forgets = false;
    for (int i = core_states; i < belief.size; ++i) {
        const SlowState& slow = belief.slow[static_cast<std::size_t>(i - core_states)];
        const double over = seconds * slow.per_second + metres * slow.per_metre;
        // Many have the same memory.
        const bool as_before = i > core_states && over == seconds * belief.slow[static_cast<std::size_t>(i - core_states - 1)].per_second +
                                                              metres * belief.slow[static_cast<std::size_t>(i - core_states - 1)].per_metre;
        keep[i] = as_before ? keep[i - 1] : std::exp(-over);
        forgets |= keep[i] != 1;
    }
    if (!forgets) return;
    for (int j = core_states; j < belief.size; ++j) {
        belief.mean[j] *= keep[j];
        auto column = belief.covariance.col(j).head(belief.size);
        column = keep[j] * column.cwiseProduct(keep.head(belief.size));
        belief.covariance.row(j).head(core_states) = belief.covariance.col(j).head(core_states).transpose();
        belief.covariance(j, j) += (1 - keep[j] * keep[j]) * belief.slow[static_cast<std::size_t>(j - core_states)].variance;
    }
}

}  // namespace roomfix
