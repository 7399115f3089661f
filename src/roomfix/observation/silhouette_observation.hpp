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

/// Holds no memory of its own, so that a list of them can be reused frame after frame.
struct SilhouetteObservation {
    int robot = 0;  // index in the site's robots
    Pose2 pose;     // the best pose, map; yaw means nothing if `yaw_known` is false
    bool yaw_known = true;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();                          // x, y, yaw; m, rad; with the camera's calibration in it
    Eigen::Matrix<double, 3, 6> by_calibration = Eigen::Matrix<double, 3, 6>::Zero();  // by the six independent errors of the view's calibration
    int like_turns = 1;                                                                // so many turns in a circle look the same
    FixedList<PoseHypothesis, 4> hypotheses;                                           // all poses that may be it, the best first
    double support = 0;                                                                // part of the visible outline that the picture confirms, 0..1
    double visible = 0;                      // part of the outline that is inside the picture and not behind another robot, 0..1
    double edges = 0;                        // nats by which the edges found along an outline speak for it, against those that lie anywhere by chance
    double exact = 0;                        // nats by which the picture shows the very solid, and not a robot that is only about so large
    bool doubtful = false;                   // an outline that the body's whole area does not plainly confirm
    FixedList<Eigen::Vector2f, 64> outline;  // px, closed polygon, for drawing
};

}  // namespace roomfix
