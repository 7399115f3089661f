// What a fixed camera says about one robot at one time.
#pragma once

#include <Eigen/Core>

#include "roomfix/base/fixed_list.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

/// One of several poses that explain the same picture.
struct PoseHypothesis {
    Pose2 pose;
    double weight = 1;  // all weights of an observation add up to 1
};

/// What a robot's description leaves out, or something that hides a part of it, moves its place in the same way for some seconds.
struct LastingError {
    Eigen::Matrix3d root = Eigen::Matrix3d::Zero();  // x, y, yaw by independent errors of standard deviation 1; m, rad
    int only_camera = -1;                            // the one of a moment's cameras that shows the robot: it errs in its own way; -1: several do
};

constexpr std::size_t most_kinds = 8;  // of robots on a site, as far as evidence tells them apart

/// Holds no memory of its own, so that a list of them can be reused frame after frame.
struct SilhouetteObservation {
    int robot = 0;  // index in the site's robots
    Pose2 pose;     // the best pose, map; yaw means nothing if `yaw_known` is false
    bool yaw_known = true;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();                          // x, y, yaw; m, rad; with the camera's calibration in it
    Eigen::Matrix<double, 3, 6> by_calibration = Eigen::Matrix<double, 3, 6>::Zero();  // by the six independent errors of the view's calibration
    LastingError lasting;                                                              // part of the covariance
    int like_turns = 1;                                                                // so many turns in a circle look the same
    FixedList<PoseHypothesis, 4> hypotheses;                                           // all poses that may be it, the best first
    double support = 0;                                                                // part of the visible outline that the picture confirms, 0..1
    double visible = 0;                      // part of the outline that is inside the picture and not behind another robot, 0..1
    double edges = 0;                        // nats by which the edges found along an outline speak for it, against those that lie anywhere by chance
    double exact = 0;                        // nats by which the picture shows the very solid, and not a robot that is only about so large
    FixedList<double, most_kinds> kinds;     // nats by which a robot of each kind (kinds_of()) explains it beside one of its own kind; empty: nobody looked
    double existence = 1;                    // probability that a robot stands there, and neither nothing nor another thing
    bool doubtful = false;                   // an outline that the body's whole area does not plainly confirm
    FixedList<Eigen::Vector2f, 64> outline;  // px, closed polygon, for drawing
};

}  // namespace roomfix
