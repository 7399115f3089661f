// A robot's middle and another point of it: the truth is often that of a marker, a receiver or a prism somewhere on the robot.
#pragma once

#include <optional>
#include <vector>

#include "roomfix/evaluate/truth.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix {

/// How a point's place and the robot's yaw follow from the middle's place and the yaw: derivatives at `yaw` (rad) of x + R(yaw) point, yaw.
/// `point`: m, robot frame (x forward, y left).
Eigen::Matrix3d point_from_middle(const Eigen::Vector2d& point, double yaw);

/// The fix of a point instead of the middle, with its covariance. Nothing where the yaw is not known, since the point may then be on any side.
std::optional<Fix> fix_of_point(const Fix& fix, const Eigen::Vector2d& point);

/// Where the middles were, each with a yaw, for what has to be linearised at the truth. A yaw that the truth of the point lacks is that of the
/// robot's fixes around, or else where the point moved to.
Truth true_middles(const Truth& truth, const std::vector<Fix>& fixes, const Eigen::Vector2d& point);

}  // namespace roomfix
