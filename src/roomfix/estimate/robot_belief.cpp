#include "roomfix/estimate/robot_belief.hpp"

#include <Eigen/LU>
#include <algorithm>

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

}  // namespace

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
            all[k].log_weight = std::log(std::exp(all[k].log_weight) + std::exp(all[i].log_weight));
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
