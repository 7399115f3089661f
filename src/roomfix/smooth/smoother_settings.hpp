#pragma once

#include "roomfix/base/time.hpp"

namespace roomfix {

struct SmootherSettings {
    Nanoseconds step = 100'000'000;    // at most between two knots
    Nanoseconds closest = 10'000'000;  // knots, at least apart
    double window = 120;               // s that are smoothed at once; 0: the whole session
    double overlap = 5;                // s more on either side of a window, that are then left to its neighbours
    int most_iterations = 30;
    bool lasting = false;        // calibrations and places of landmarks stay what they are all the time
    double same_place = 0;       // m, and ...
    double same_heading = 0.35;  // rad: what a source sees of a robot within these has the same errors and counts once; 0: errors are white noise
};

}  // namespace roomfix
