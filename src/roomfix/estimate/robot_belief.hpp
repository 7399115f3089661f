// All that is believed of one robot: a few hypotheses with their weights, nearly always one.
#pragma once

#include <vector>

#include "roomfix/base/time.hpp"
#include "roomfix/estimate/update.hpp"

namespace roomfix {

struct Hypothesis {
    Belief belief;
    double log_weight = 0;
    Nanoseconds placed = 0;  // when it was put where it is by anything but driving
};

/// The heaviest first; the weights add up to 1.
struct RobotBelief {
    std::vector<Hypothesis> hypotheses;

    const Belief& best() const { return hypotheses.front().belief; }
    Nanoseconds placed() const { return hypotheses.front().placed; }
    double best_weight() const { return std::exp(hypotheses.front().log_weight); }
};

constexpr std::size_t most_hypotheses = 16;
constexpr double least_log_weight = -11;  // lighter ones are dropped

/// Weighs the hypotheses by log evidences (one each). One event may move the balance between two of them by `budget` at most: errors
/// of one source are alike from one moment to the next. Returns what was used of the budget.
double weigh(RobotBelief& robot, const std::vector<double>& log_evidence, double budget);

/// Adds a hypothesis with a share (0..1) of all weight.
void add_hypothesis(RobotBelief& robot, const Belief& belief, double share);

/// Sorts, joins hypotheses that have become the same (mean and covariance of both together), drops the lightest, and makes the weights add up to 1.
void settle(RobotBelief& robot);

/// Splits hypotheses that are so vague that nothing is straight any more into several narrow ones, which together are the same (a sum of Gaussians).
/// `place`: m, `front`: rad, standard deviations of which a hypothesis need not be split.
void split_vague(RobotBelief& robot, double place, double front);

/// Squared Mahalanobis distance between two poses, each with its uncertainty.
double pose_distance(const Belief& a, const Belief& b);

}  // namespace roomfix
