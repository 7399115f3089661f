// Which moment of the clock a time stamp is.
#pragma once

#include "roomfix/base/time.hpp"

namespace roomfix {

struct Pace {
    double wall = 0;       // s, steady clock ...
    Nanoseconds time = 0;  // ... and the time stamp of the same moment
    double speed = 1;      // seconds of time stamps in one second of the clock

    double wall_of(Nanoseconds t) const { return wall + to_seconds(t - time) / speed; }
};

}  // namespace roomfix
