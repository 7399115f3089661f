// A camera's pose in space as a pose on the floor.
#pragma once

#include <Eigen/Core>

#include "roomfix/geometry/pose.hpp"

namespace roomfix {

struct PoseFromAbove {
    Pose2 pose;             // x and y of the camera; yaw: where the optical axis points, seen from above
    bool yaw_known = true;  // not of a camera that looks straight up or down
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
};

PoseFromAbove seen_from_above(const UncertainPose3& map_from_camera);

}  // namespace roomfix
