// A camera that rides on a robot: where it sees a point of the map.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "roomfix/geometry/calibration.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

/// A camera that rides on a robot.
struct CameraOnRobot {
    CameraModel model;
    UncertainPose3 robot_from_camera;  // its covariance: what the intrinsics have no part in
    IntrinsicsErrors intrinsics = {};
};

/// All that is uncertain of the camera, as six independent errors.
CalibrationRoot calibration_root(const CameraOnRobot& camera);

/// The pixel of a map point for a robot at `pose`; nothing where the camera does not see it. `by_pose`, `by_mount` and `by_point`
/// (m of the map) are its derivatives, if asked for.
struct SeenPointJacobian {
    Eigen::Matrix<double, 2, 3> by_pose;   // x, y, yaw
    Eigen::Matrix<double, 2, 6> by_mount;  // error vector of UncertainPose3
    IntrinsicsJacobian by_intrinsics;      // zero where they are exact
    Eigen::Matrix<double, 2, 3> by_point;
};
std::optional<Eigen::Vector2d> predict_point(const CameraOnRobot& camera, const Pose2& pose, const Eigen::Vector3d& map_point,
                                             SeenPointJacobian* jacobian = nullptr);

}  // namespace roomfix
