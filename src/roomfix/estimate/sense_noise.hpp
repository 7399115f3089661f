// How a robot's own senses err beyond what is stated of them: learned while it drives (noise_learner.hpp).
#pragma once

#include <cmath>

#include "roomfix/estimate/motion.hpp"
#include "roomfix/estimate/range_stretch.hpp"

namespace roomfix {

/// Of ranges, by receivers or by a detector. Zero: there is no such error.
struct RangeErrors {
    double factor = 1;      // times the stated sigma
    double common = 0;      // m, standard deviation of what all ranges have in common
    double own = 0;         // m, of what the ranges to one beacon have in common
    double wander = 0;      // m, of what the ranges to one beacon have in common and what changes with the place
    double sway = 0;        // m, of what all ranges have in common and what changes with the place
    double way = 1;         // times the way over which what changes with the place is another (TrackerSettings::wander_way); bearings', too
    StretchErrors stretch;  // parts of the range
};

struct SenseNoise {
    double way = 1;    // times the wheels' random errors of the way
    double turn = 1;   // ... and of the turning
    double delay = 0;  // s: the robot moves so much later than the wheels say
    double push = 1;   // where no wheels tell how it moves: times the accelerations that robots are taken to have ...
    double twist = 1;  // ... and the changes of their turning
    RangeErrors receiver, detector;
    double bearing = 1;         // times the stated sigma of bearings
    double bearing_common = 0;  // rad, standard deviation of what all bearings have in common
    double bearing_shape = 0;   // rad, of what depends on the bearing itself: lenses that bend, scanners that run out of true
    double bearing_sway = 0;    // rad, of what all bearings have in common and what changes with the place
};

/// The wheels' noise as it was learned.
inline OdometryNoise learned(OdometryNoise noise, const SenseNoise& sense) {
    noise.along *= sense.way;
    noise.across *= std::sqrt(sense.way);  // wheels slip along their way rather than across it
    noise.turn_per_metre *= sense.turn;
    noise.turn_per_radian *= sense.turn;
    noise.delay = sense.delay;
    return noise;
}

/// How the robot moves, as it was learned.
inline MotionModel learned(MotionModel motion, const SenseNoise& sense) {
    motion.acceleration *= sense.push;
    motion.side_acceleration *= sense.push;
    motion.turning *= sense.twist;
    return motion;
}

}  // namespace roomfix
