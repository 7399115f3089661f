// Are errors as large as their covariances say? And how small could they be?
#pragma once

#include <Eigen/Core>
#include <vector>

#include "roomfix/geometry/pose.hpp"

namespace roomfix {

/// fix - truth: x, y in m and yaw in rad, taken modulo `symmetry` (0: yaw error is 0).
Eigen::Vector3d pose_error(const Pose2& fix, const Pose2& truth, double symmetry);

/// Normalised estimation error squared e^T P^-1 e; its mean is the number of unknowns if P is true.
/// Infinity if P is not positive definite.
double nees(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance);

/// What a fix's covariance says of its error: a part of its own, and one that it shares with all fixes of its group, such as those of one calibration.
struct StatedError {
    Eigen::MatrixXd own;     // n x n, covariance
    Eigen::MatrixXd shared;  // n x k, k > 0: the group's k errors, each of sigma 1, enter like this
    int group = 0;
};

/// Holds 95 % of such fixes' mean NEES if their covariances are true. Where they share much, groups count rather than fixes. Found by simulation.
struct NeesBand {
    double low = 0, high = 0;
};
NeesBand mean_nees_band(const std::vector<StatedError>& errors);

struct Summary {
    std::size_t count = 0;
    double mean = 0, rms = 0, median = 0, p95 = 0, max = 0;
};
Summary summarise(std::vector<double> values);

/// Trials of an experiment: each with `ours` (optional), `error` and `covariance`.
template <class Trial>
int count_lost(const std::vector<Trial>& trials) {
    int count = 0;
    for (const Trial& t : trials) count += !t.ours;
    return count;
}

/// Mean NEES over the trials that gave a fix; 0 if none did.
template <class Trial>
double mean_nees_of(const std::vector<Trial>& trials) {
    double sum = 0;
    for (const Trial& t : trials) sum += t.ours ? nees(t.error, t.covariance) : 0;
    const std::size_t found = trials.size() - static_cast<std::size_t>(count_lost(trials));
    return found > 0 ? sum / static_cast<double>(found) : 0;
}

}  // namespace roomfix
