// Fixes, poses on the floor and cameras as ROS messages.
#pragma once

#include <string>

#include "roomfix/connect/ros_message.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix::ros {

/// Has the fix a place, with a covariance that is one (finite, symmetric, positive definite)?
bool has_pose(const Fix& fix);

/// A pose on the floor, in space.
Pose pose_of(const Pose2& pose);

/// Of x, y, yaw, in all six axes. The floor is flat within a centimetre and a hundredth of a radian. A yaw that is not known is anywhere.
Covariance planar_covariance(const Eigen::Matrix3d& covariance, bool yaw_known);

/// In the frame `map`. The fix must have a pose; a yaw that is not known is written as 0, with the variance of all directions alike.
PoseWithCovarianceStamped pose_message(const Fix& fix);

/// Has the fix a velocity in the robot's own axes: a velocity and a yaw, each with a covariance that is one?
bool has_twist(const Fix& fix);

/// In the frame `map`, of the robot's frame `child`, with the twist in its axes. The fix must have a pose and a twist. That the errors of yaw and velocity go
/// together is not known here: the twist's variance across is never too small for it.
Odometry odometry_message(const Fix& fix, const std::string& child);

TransformStamped transform_message(Nanoseconds time, const std::string& frame, const std::string& child, const Pose2& frame_from_child);

/// Where the frame `odom` is in the map, from where the robot is in both at the same time.
Pose2 map_from_odom(const Pose2& map_from_base, const Pose2& odom_from_base);

/// Of pictures as they come from the camera: neither cut, nor scaled, nor rectified.
CameraInfo camera_info_message(Nanoseconds time, const std::string& frame, const CameraModel& model);

}  // namespace roomfix::ros
