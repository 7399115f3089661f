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

struct Summary {
    std::size_t count = 0;
    double mean = 0, rms = 0, median = 0, p95 = 0, max = 0;
};
Summary summarise(std::vector<double> values);

}  // namespace roomfix
