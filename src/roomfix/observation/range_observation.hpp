// What a receiver on a robot says about its distance to beacons.
#pragma once

#include <array>

#include "roomfix/base/time.hpp"

namespace roomfix {

/// The distance from a robot's receiver to a beacon.
struct RangeObservation {
    Nanoseconds time = 0;
    int robot = 0;     // index in the site's robots
    int beacon = 0;    // index in the site's beacons
    double range = 0;  // m
    double sigma = 0;  // m, where the signal came the straight way
    int receiver = 0;  // index in the robot's receivers
};

/// How much farther beacon b is than beacon a, as radio anchors measure it: |p - B| - |p - A|.
struct RangeDifferenceObservation {
    Nanoseconds time = 0;
    int robot = 0;
    std::array<int, 2> beacons = {0, 0};  // a, b
    double difference = 0;                // m
    double sigma = 0;                     // m
    int receiver = 0;                     // index in the robot's receivers
};

}  // namespace roomfix
