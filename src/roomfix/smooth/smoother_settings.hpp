// How a session is smoothed.
#pragma once

#include "roomfix/base/time.hpp"

namespace roomfix {

struct SmootherSettings {
    Nanoseconds step = 100'000'000;    // at most between two knots
    Nanoseconds closest = 10'000'000;  // knots, at least apart
    double window = 300;               // s that are smoothed at once; 0: the whole session
    double overlap = 60;               // s more on either side of a window, that are then left to its neighbours
    int most_iterations = 30;
    bool lasting = false;        // what is_lasting() stays as it is for the whole session
    double same_place = 0;       // m; 0: a source's errors are white noise. Otherwise what it sees of a robot within this ...
    double same_heading = 0.35;  // ... and within so many rad has the same errors, and counts once
};

}  // namespace roomfix
