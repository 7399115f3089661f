// Where a robot's wheels say that it was, between their reports.
#pragma once

#include <optional>
#include <span>

#include "roomfix/observation/odometry_observation.hpp"

namespace roomfix {

/// The pose in the robot's frame `odom` at a time, from the reports before and after it, which are of one robot and in the order of their times.
/// Nothing where one of the two is missing, or they do not belong together: more than a second apart, or faster than a robot (15 m/s).
std::optional<Pose2> odometry_at(std::span<const OdometryObservation> reports, Nanoseconds time);

}  // namespace roomfix
