// That a robot is not seen where it should be.
#pragma once

#include "roomfix/geometry/pose.hpp"

namespace roomfix {

struct AbsenceObservation {
    int robot = 0;    // index in the site's robots
    Pose2 place;      // map: where it should be
    double nats = 0;  // how much likelier what the cameras show is if it stands there than if nothing does; negative
};

}  // namespace roomfix
