// What a robot's own detector says about a landmark.
#pragma once

#include <optional>

#include "roomfix/base/time.hpp"

namespace roomfix {

/// A landmark as seen from the robot's origin: how far away, level with the floor, or in which direction, or both.
struct SightingObservation {
    Nanoseconds time = 0;
    int robot = 0;                  // index in the site's robots
    int landmark = -1;              // index in the site's landmarks; -1: it does not say which
    std::optional<double> range;    // m
    std::optional<double> bearing;  // rad, to the left of straight ahead
    double range_sigma = 0.05;      // m
    double bearing_sigma = 0.01;    // rad
};

}  // namespace roomfix
