// A landmark's points as a camera on the robot sees them: LEDs or the corners of a tag, in pixels.
#pragma once

#include "roomfix/estimate/update.hpp"
#include "roomfix/geometry/onboard_view.hpp"
#include "roomfix/observation/landmark_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// A camera on a robot, for the tracker.
struct OnboardSource {
    int source = 0;  // of the tracker's sources
    CameraOnRobot camera;
    CalibrationRoot calibration = CalibrationRoot::Zero();  // zero where mount and lens are known exactly
    double time_offset_sigma = 0;                           // s; 0: its time stamps are right
    double readout = 0;                                     // s from when the first row is exposed until the last one is
};
OnboardSource onboard_source(int source, const CameraOnRobot& camera);

/// A landmark of the site.
struct KnownLandmark {
    int number = 0;                                        // index in the site
    const std::vector<Eigen::Vector3d>* points = nullptr;  // m, map
    double sigma = 0.002;                                  // m, of each coordinate of its position
};

/// Prepares the slow states of the mount's and the time stamps' errors, and of the landmark's place: x, y and, with 3 directions, z. An error without a state
/// is taken for noise.
void add_slow_states(Belief& belief, const OnboardSource& source, const TimeError& error);
void add_slow_states(Belief& belief, const KnownLandmark& landmark, const OnboardSource& source, const TimeError& error, int directions = 2);

/// The observation's points are in the landmark's order. Nothing where one of them is out of the camera's sight. `Points`: 3 for LEDs,
/// 4 for a tag.
template <int Points>
std::optional<Linearised<2 * Points>> linearise_points(const Belief& belief, const LandmarkObservation& seen, const KnownLandmark& landmark,
                                                       const OnboardSource& source);

/// Takes a landmark into the belief, linearised again where needed. Nothing where it cannot be seen from there.
std::optional<Innovation> update_landmark(Belief& belief, const LandmarkObservation& seen, const KnownLandmark& landmark, const OnboardSource& source,
                                          const OutlierModel& outliers);

}  // namespace roomfix
