// A robot's pose as one source sees it at one time: what the tracker takes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "roomfix/geometry/pose.hpp"
#include "roomfix/observation/silhouette_observation.hpp"
#include "roomfix/observation/time_error.hpp"

namespace roomfix {

struct PoseObservation {
    int robot = 0;  // index in the site's robots
    Pose2 pose;     // map
    bool yaw_known = true;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // x, y, yaw; m, rad
    int like_turns = 1;                                        // so many turns in a circle look the same: 2 for a box, 4 for a square one
    Eigen::Matrix<double, 3, 6> by_calibration = Eigen::Matrix<double, 3, 6>::Zero();  // by the six independent errors of a fixed camera's calibration
    LastingError lasting;                                                              // part of the covariance
    FixedList<double, most_kinds> kinds;                                               // as of a SilhouetteObservation
    double tells_kind = 0.3;                                                           // where `kinds` is empty: nats by which it is this kind of robot
    double late = 0;                                                                   // s after the frame's time: a rolling shutter reads its rows later
    TimeError time_error;
    bool identified = false;  // by a tag: it is this one, not one that looks the same
};

inline std::vector<PoseObservation> poses_of(const std::vector<SilhouetteObservation>& silhouettes) {
    std::vector<PoseObservation> poses;
    for (const auto& o : silhouettes) {
        poses.push_back({o.robot, o.pose, o.yaw_known, o.covariance, o.like_turns, o.by_calibration, o.lasting, o.kinds});
        if (o.exact > 0) poses.back().tells_kind = 3;
    }
    return poses;
}

}  // namespace roomfix
