// Two robots of the same look that pass each other, or turn back just there: what the experiments about them share.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "roomfix/base/random.hpp"
#include "roomfix/estimate/tracker.hpp"
#include "roomfix/evaluate/identity_experiment.hpp"
#include "roomfix/simulate/wheel_simulator.hpp"

namespace roomfix {

inline const Box crossing_body{0.54, 0.54, 0.45};

/// A robot of that body on two wheels with odometry.
SiteRobot wheeled_robot(const std::string& id);
/// r1 and r2, with odometry or without.
std::vector<SiteRobot> like_robots(bool odometry);

/// Along x through the middle at `speed`, or towards it and back: a turn takes a second on the spot.
struct Passage {
    double side = -1;  // which end it starts from
    double lane = 0;   // m, its y
    double speed = 0.4;
    double meet = 5;  // s, when it is in the middle
    bool turns_back = false;

    Pose2 at(double time) const;
};
/// r1 from the left in the lane -`half`, r2 from the right in the lane +`half`; half of all turn back.
std::array<Passage, 2> random_passages(double half, Random& random);

/// Scale and drift errors of 1 % and 0.01 rad/s (1 sigma).
WheelModel random_wheels(Random& random);
std::array<WheelSimulator, 2> wheels_of(const std::array<Passage, 2>& ways, Random& random);
void tell_wheels(Tracker& tracker, int robot, const std::vector<WheelPose>& poses);

/// The fix of that name; one of status none if there is none.
Fix named_fix(const std::vector<Fix>& fixes, const std::string& robot);
double distance(const Fix& fix, const Pose2& truth);

/// Does any fix at a time say that it may be the other robot?
bool in_doubt(const Tracker& tracker, double time);
/// Adds what became of the names. `doubtful`: some fix since the crossing said that it might be the other.
void judge_crossing(const Tracker& tracker, const std::array<Passage, 2>& ways, double time, bool doubtful, CrossingResult& result);

}  // namespace roomfix
