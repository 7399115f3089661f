// A robot's pose at a time in the map: what roomfix gives.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/time.hpp"
#include "roomfix/observation/silhouette_observation.hpp"

namespace roomfix {

enum class FixStatus { ok, coasting, none };

/// A source's normalised innovation squared: how surprising its last observation was.
struct InnovationSquare {
    std::string source;
    double nis = 0;
    int dimensions = 0;
};

/// Where the time from a frame to its fix went, s.
struct LatencyParts {
    double waiting = 0;   // until the frame was looked at: exposure, transfer, decoding, queues
    double looking = 0;   // one camera's own look
    double fitting = 0;   // bodies, in all cameras of the moment together
    double tracking = 0;  // all else until the fix was given
};

struct Fix {
    Nanoseconds time = 0;
    std::string robot;     // empty if none was found
    bool unknown = false;  // no robot of the site; `robot` is the name given to what stands there
    FixStatus status = FixStatus::none;
    Pose2 pose;
    bool yaw_known = true;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();           // x, y, yaw; m, rad
    std::optional<Eigen::Vector3d> velocity;                            // vx, vy in the map, turning; m/s, rad/s
    Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Identity();  // of it
    std::vector<std::string> sources;
    std::string image;   // the picture it comes from, if it comes from one
    std::string reason;  // for status none, in plain words
    std::vector<PoseHypothesis> hypotheses;
    std::vector<InnovationSquare> nis;                 // of the observations of that very time
    double existence = 1;                              // probability that a robot stands there, and neither nothing nor another thing
    double identity = 1;                               // probability that it is this robot and not one that looks the same
    std::optional<double> latency;                     // s of the clock, from the frame's time until the fix was given
    std::optional<LatencyParts> latency_parts;         // that make it up, where a frame was looked at
    std::optional<Eigen::Isometry3d> map_from_camera;  // of a fix that is a camera's whole pose
};

}  // namespace roomfix
