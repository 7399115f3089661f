// A camera for tests that need no rendered picture.
#pragma once

#include "roomfix/base/decompositions.hpp"
#include "roomfix/geometry/view.hpp"

namespace roomfix {

/// A camera at `from` that looks at `at` (m, map), `up` (map) upright in its picture. Its place and direction are known within 1 mm and 1 mrad.
inline View standing_camera(const CameraModel& model, const Eigen::Vector3d& from, const Eigen::Vector3d& at,
                            const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ()) {
    UncertainPose3 pose;
    const Eigen::Vector3d forward = (at - from).normalized();
    const Eigen::Vector3d right = forward.cross(up).normalized();
    pose.pose = Eigen::Isometry3d::Identity();
    pose.pose.linear() << right, forward.cross(right), forward;
    pose.pose.translation() = from;
    pose.covariance = 1e-6 * Matrix6d::Identity();
    return View(model, pose);
}

/// The same with a camera of 640 x 480 px whose lens is 500 px long.
inline View standing_camera(const Eigen::Vector3d& from, const Eigen::Vector3d& at) {
    return standing_camera(make_camera_model(640, 480, 500, 500, 320, 240), from, at);
}

}  // namespace roomfix
