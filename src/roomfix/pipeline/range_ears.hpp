// The receivers of all robots: what each heard last.
#pragma once

#include <vector>

#include "roomfix/observation/range_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

class RangeEars {
public:
    /// One ear for each robot with a receiver.
    explicit RangeEars(const Site& site = {});

    bool empty() const { return ears_.empty(); }
    bool hears(int robot) const { return find(robot) != nullptr; }
    /// Takes a range if the robot has a receiver.
    void keep(const RangeObservation& range);
    /// The robot's newest range to each beacon, if it is not too old.
    std::vector<RangeObservation> near(int robot, Nanoseconds time) const;

private:
    struct Ear {
        int robot = 0;
        std::vector<RangeObservation> heard;  // the newest of each beacon
    };
    const Ear* find(int robot) const;

    std::vector<Ear> ears_;
};

}  // namespace roomfix
