// Robots that enter and leave zones.
#pragma once

#include <string>

#include "roomfix/base/time.hpp"

namespace roomfix {

struct ZoneEvent {
    Nanoseconds time = 0;
    std::string zone;
    std::string robot;
    bool entered = false;  // else: left
};

}  // namespace roomfix
