// A hall with everything that can locate a robot, and a robot that drives through it at random.
#pragma once

#include <vector>

#include "roomfix/base/random.hpp"
#include "roomfix/estimate/motion.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// What locates the robot.
struct HallSenses {
    bool cameras = false;  // two fixed ones
    bool ceiling = false;  // landmarks that all look alike
    bool corners = false;  // four that all look alike
    bool ranges = false;   // to six beacons, one in ten late
    bool odometry = false;
};

/// Two wall cameras, one that looks up and one that looks for corners on the robot, landmarks that look alike, four like corners, six
/// beacons. All are described; the senses say which are used, and whether anything shows the robot's front.
Site hall_site(const HallSenses& senses);

/// States of the tracker's own kind.
struct TrueMotion {
    static constexpr double step = 0.005;  // s
    std::vector<StateVector> states;

    StateVector at(double time) const;
};

/// Accelerates at random, as the motion model says. Stretches that would leave the hall are driven anew.
TrueMotion drive_through_hall(double seconds, const MotionModel& model, Random& random);

}  // namespace roomfix
