// What a robot's wheels say.
#pragma once

#include "roomfix/base/time.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

/// The dead-reckoned pose in the robot's own `odom` frame, which starts anywhere and drifts.
struct OdometryObservation {
    Nanoseconds time = 0;
    int robot = 0;  // index in the site's robots
    Pose2 pose;
};

}  // namespace roomfix
