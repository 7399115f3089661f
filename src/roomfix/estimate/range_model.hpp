// Ranges and range differences from a receiver on the robot to beacons.
#pragma once

#include "roomfix/estimate/sense_noise.hpp"
#include "roomfix/estimate/update.hpp"
#include "roomfix/observation/range_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// What is known of the ranges that one receiver hears.
struct RangeSource {
    Eigen::Vector3d receiver = Eigen::Vector3d::Zero();  // m, robot frame
    LateModel late;
    double bias_sigma = 0;                                     // m: how far all ranges may be off; 0: not at all
    StretchErrors stretch;                                     // parts of the range
    double bias_memory = 600;                                  // s: over that time these change
    double own_sigma = 0;                                      // m: how far those to one beacon may be off besides
    double wander_sigma = 0;                                   // m: what those to one beacon have in common and what changes with the place
    double sway_sigma = 0;                                     // m: what all have in common and what changes with the place
    double wander_way = 1;                                     // m: over that way it is another
    double factor = 1;                                         // times the stated sigma of a range
    int number = 0;                                            // of the receiver
    Eigen::Vector3d receiver_sigma = Eigen::Vector3d::Zero();  // m, along each axis of the robot
};

constexpr double own_part = 0.25;  // of a stated bias: what beacons do not have in common

/// With the errors that were learned.
RangeSource learned(RangeSource source, const RangeErrors& errors);

/// A predicted range with its derivatives by the pose.
struct PredictedRange {
    double range = 0;                                   // m
    Eigen::Vector3d by_pose = Eigen::Vector3d::Zero();  // x, y, yaw
};
PredictedRange predict_range(const Pose2& pose, const Eigen::Vector3d& receiver, const Eigen::Vector3d& beacon);

/// What is expected of a range or range difference at `at`, with its derivatives by the belief's states.
struct PredictedValue {
    double value = 0;  // m
    FixedList<int, most_columns> states;
    Eigen::Matrix<double, 1, most_columns> by_state = Eigen::Matrix<double, 1, most_columns>::Zero();
};

/// Prepares the slow states of a beacon's ranges.
void add_slow_states(Belief& belief, int beacon, const RangeSource& source);
PredictedValue predict_measured_range(const Belief& belief, const Pose2& at, int beacon, const Eigen::Vector3d& position, const RangeSource& source);
/// Distance to the second beacon minus distance to the first.
PredictedValue predict_difference(const Belief& belief, const Pose2& at, const Eigen::Vector3d& first, const Eigen::Vector3d& second,
                                  const RangeSource& source);

/// Takes a range into the belief; linearised again where the robot is near the beacon.
Innovation update_range(Belief& belief, const RangeObservation& observation, const Eigen::Vector3d& beacon, const RangeSource& source);

/// Takes a range difference: distance to the second beacon minus distance to the first.
Innovation update_difference(Belief& belief, const RangeDifferenceObservation& observation, const Eigen::Vector3d& first, const Eigen::Vector3d& second,
                             const RangeSource& source);

}  // namespace roomfix
