// What goes into a look at a camera's frame and what comes out of it, whatever kind of camera it is.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomfix/estimate/event.hpp"
#include "roomfix/observation/fix.hpp"
#include "roomfix/overhead/body_observer.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

class Tracker;

constexpr double likely = 0.9;  // weight of a place that is believed, and of a corner that is named

/// What is known before a frame is looked at.
struct FrameHints {
    std::optional<Nanoseconds> time;  // of the frame; nothing where it is one by itself
    // Of a fixed camera:
    bool bodies = true;           // looks for whole bodies by itself
    Expectation robots;           // where they should be
    std::vector<char> elsewhere;  // of each robot: 1 if it surely is where the camera does not see it
    // Of a camera that finds its own place:
    std::vector<RangeObservation> ranges;     // of the robot that carries it
    std::optional<PoseObservation> expected;  // where that robot should be
    int landmark = -1;                        // index in the site: this one is seen
    int corner = -1;                          // the same of a corner
    std::optional<double> heading;            // rad: where it looks, seen from above, give or take 15 deg
};

/// A robot in one frame, without what other frames tell of it.
struct SeenRobot {
    int robot = -1;  // index in the site's robots; -1: the camera's own place
    Pose2 pose;
    bool yaw_known = true;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // x, y, yaw; m, rad
    std::vector<PoseHypothesis> hypotheses;                    // all poses that explain the frame, the best first; empty: this one alone
    std::optional<Eigen::Isometry3d> map_from_camera;          // where the frame tells the camera's whole pose
    double existence = 1;                                      // probability that a robot stands there, and neither nothing nor another thing
};

/// What one frame showed.
struct Sighting {
    // For the tracker:
    bool sees_all = false;               // a fixed camera: that a robot is not among `poses` says something, too
    std::vector<PoseObservation> poses;  // of robots; the index behind the last robot is what is none
    std::vector<AbsenceObservation> absent;
    std::vector<TagSighting> tags;
    std::optional<LandmarkSighting> landmarks;
    std::optional<CornerSighting> corners;
    // For a fix of this frame alone:
    std::vector<SeenRobot> robots;
    std::string reason;  // why it showed no robot
};

/// How far the frame's time may be off, of all that was seen in it.
void set_time_error(Sighting& sighting, const TimeError& error);

/// Tells the tracker. `camera`: the name under which it knows the camera.
void feed(Tracker& tracker, Nanoseconds time, const std::string& camera, const Sighting& sighting);

/// A fix of each robot that the frame showed; of a frame without one a fix that says why.
std::vector<Fix> fixes_of(const Sighting& sighting, const Site& site, Nanoseconds time, const std::vector<std::string>& sources);

}  // namespace roomfix
