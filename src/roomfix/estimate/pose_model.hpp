// A robot's pose as a fixed camera measures it: by its outline or its tag.
#pragma once

#include "roomfix/estimate/update.hpp"
#include "roomfix/observation/pose_observation.hpp"

namespace roomfix {

/// What slow errors a fixed camera has.
struct PoseSource {
    int source = 0;                  // of the tracker's sources
    bool calibrated_exactly = true;  // its fixes do not move with errors of its calibration
    // s, over which what was learned of its pose fades. Outlines err alike wherever a robot comes by again: without it a calibration follows their errors,
    // ever more sure (the same way there and back: squares of the errors 0.8 times what is stated at first, 1.2 after 5 minutes, 1.6 after 14; with it 0.9).
    double calibration_memory = 200;
    double body_memory = 2;        // s: over that time what a robot's description leaves out errs otherwise
    double time_offset_sigma = 0;  // s; 0: its time stamps are right
    double readout = 0;            // s from when the first row is exposed until the last one is
};

/// Where the robot is some time (s, also before) after that of the belief: what a row shows that is exposed later than its picture's middle one.
Pose2 moved(const Belief& belief, double seconds);

/// Prepares the slow states of the camera's errors: its time stamps and its pose.
void add_slow_states(Belief& belief, const PoseSource& source, const TimeError& error);

/// Prepares the slow states that the observation needs; call it before `linearise_pose`.
void add_slow_states(Belief& belief, const PoseObservation& observation, const PoseSource& source);

/// Residual of x, y, yaw (m, m, rad); the yaw that looks the same and is nearest is meant. The parts of the covariance that last
/// belong to the slow states, the rest is noise.
Linearised<3> linearise_pose(const Belief& belief, const PoseObservation& observation, const PoseSource& source);

/// The same for x and y alone, of a robot without a front.
Linearised<2> linearise_place(const Belief& belief, const PoseObservation& observation, const PoseSource& source);

}  // namespace roomfix
