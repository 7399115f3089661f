#include "roomfix/estimate/robot_belief.hpp"

#include <algorithm>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

/// Hypotheses whose poses are closer than that have become one.
constexpr double same = 0.5;

void normalise(RobotBelief& robot) {
    double sum = 0;
    double most = robot.hypotheses.front().log_weight;
    for (const Hypothesis& h : robot.hypotheses) most = std::max(most, h.log_weight);
    for (const Hypothesis& h : robot.hypotheses) sum += std::exp(h.log_weight - most);
    for (Hypothesis& h : robot.hypotheses) h.log_weight -= most + std::log(sum);
}

bool have_the_same_states(const Belief& a, const Belief& b) {
    const auto same_error = [](const SlowState& x, const SlowState& y) { return x.kind == y.kind && x.source == y.source && x.component == y.component; };
    return a.slow.size() == b.slow.size() && std::equal(a.slow.begin(), a.slow.end(), b.slow.begin(), same_error);
}

/// Where the two are not known by the same states the heavier one stands for both.
void join(Hypothesis& kept, const Hypothesis& other) {
    const double more = std::exp(kept.log_weight), less = std::exp(other.log_weight);
    kept.log_weight = std::log(more + less);
    Belief& a = kept.belief;
    const Belief& b = other.belief;
    if (!have_the_same_states(a, b)) return;
    const double share = less / (more + less);
    StateVector off;
    off.head(a.size) = b.mean.head(a.size) - a.mean.head(a.size);
    off[state_yaw] = wrap_angle(off[state_yaw]);
    a.mean.head(a.size) += share * off.head(a.size);
    for (int j = 0; j < a.size; ++j) {
        for (int i = 0; i < a.size; ++i) a.covariance(i, j) += share * (b.covariance(i, j) - a.covariance(i, j)) + share * (1 - share) * off[i] * off[j];
    }
}

/// By how much a belief's state changes where it is one standard deviation away in its vaguest direction, and how large that may be at most, as a part of it.
struct Vagueness {
    StateVector step;
    double allowed = 1;
};
Vagueness vagueness(const Belief& belief, double place, double front) {
    constexpr double narrow = 0.8;  // of what is allowed: so it need not be split again at once
    Vagueness result;
    const double yaw_sigma = std::sqrt(belief.covariance(state_yaw, state_yaw));
    if (yaw_sigma > front) {
        result.step.head(belief.size) = belief.covariance.col(state_yaw).head(belief.size) / yaw_sigma;
        result.allowed = narrow * front / yaw_sigma;
        return result;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(Eigen::Matrix2d(belief.covariance.topLeftCorner<2, 2>()));
    const double sigma = std::sqrt(std::max(axes.eigenvalues()[1], 0.0));
    if (sigma <= place) return result;
    result.step.head(belief.size) = belief.covariance.leftCols<2>().topRows(belief.size) * axes.eigenvectors().col(1) / sigma;
    result.allowed = narrow * place / sigma;
    return result;
}

}  // namespace

void split_vague(RobotBelief& robot, double place, double front) {
    constexpr std::size_t most_parts = 9;
    constexpr double reach = 2;       // standard deviations to either side
    constexpr double overlap = 0.7;   // of the distance between two parts: standard deviation of one
    constexpr double worth_it = 0.8;  // parts must be narrower than that
    const std::size_t parts = std::min(most_hypotheses / robot.hypotheses.size(), most_parts);
    if (parts < 3) return;
    const double apart = 2 * reach / static_cast<double>(parts - 1);
    std::vector<Hypothesis> all;
    for (const Hypothesis& whole : robot.hypotheses) {
        const Vagueness vague = vagueness(whole.belief, place, front);
        const double sigma = std::max(vague.allowed, overlap * apart);
        if (sigma > worth_it) {
            all.push_back(whole);
            continue;
        }
        const double between = 1 - sigma * sigma;  // variance of the parts' middles
        double sum = 0, squares = 0;
        for (std::size_t i = 0; i < parts; ++i) {
            const double at = apart * static_cast<double>(i) - reach, weight = std::exp(-0.5 * at * at / between);
            sum += weight;
            squares += weight * at * at;
        }
        const double wider = std::sqrt(between * sum / squares);  // so that the parts' variance is that of the whole
        const int size = whole.belief.size;
        for (std::size_t i = 0; i < parts; ++i) {
            const double at = apart * static_cast<double>(i) - reach;
            Hypothesis part = whole;
            part.log_weight += -0.5 * at * at / between - std::log(sum);
            part.belief.mean.head(size) += wider * at * vague.step.head(size);
            part.belief.covariance.topLeftCorner(size, size) -= between * vague.step.head(size) * vague.step.head(size).transpose();
            all.push_back(part);
        }
    }
    robot.hypotheses = std::move(all);
}

double weigh(RobotBelief& robot, const std::vector<double>& log_evidence, double budget) {
    if (robot.hypotheses.size() < 2) return 0;
    const double most = *std::max_element(log_evidence.begin(), log_evidence.end());
    double used = 0;
    for (std::size_t i = 0; i < robot.hypotheses.size(); ++i) {
        const double behind = std::min(most - log_evidence[i], budget);
        robot.hypotheses[i].log_weight -= behind;
        used = std::max(used, behind);
    }
    normalise(robot);
    return used;
}

void add_hypothesis(RobotBelief& robot, const Belief& belief, double share) {
    const double log_weight = std::log(share / std::max(1 - share, 1e-12));
    if (robot.hypotheses.size() == most_hypotheses) robot.hypotheses.pop_back();
    robot.hypotheses.push_back({belief, robot.hypotheses.empty() ? 0 : log_weight});
    normalise(robot);
}

double pose_distance(const Belief& a, const Belief& b) {
    Eigen::Vector3d off = a.mean.head<3>() - b.mean.head<3>();
    off.z() = wrap_angle(off.z());
    const Eigen::Matrix3d spread = a.pose_covariance() + b.pose_covariance();
    return off.dot(spread.inverse() * off);
}

void settle(RobotBelief& robot) {
    auto& all = robot.hypotheses;
    if (all.size() < 2) return;
    std::stable_sort(all.begin(), all.end(), [](const Hypothesis& a, const Hypothesis& b) { return a.log_weight > b.log_weight; });
    std::size_t kept = 1;
    for (std::size_t i = 1; i < all.size(); ++i) {
        if (all[i].log_weight < least_log_weight) break;
        bool joined = false;
        for (std::size_t k = 0; k < kept && !joined; ++k) {
            if (pose_distance(all[k].belief, all[i].belief) > same) continue;
            join(all[k], all[i]);
            joined = true;
        }
        if (joined) continue;
        if (kept != i) all[kept] = all[i];
        ++kept;
    }
    all.resize(kept);
    normalise(robot);
}

}  // namespace roomfix
