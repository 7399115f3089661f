// The receivers of all robots: the ranges that came last.
#pragma once

#include <vector>

#include "roomfix/observation/range_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

class ReceiverBuffer {
public:
    explicit ReceiverBuffer(const Site& site);

    /// Takes a range if the robot has a receiver.
    void keep(const RangeObservation& range);
    /// The robot's newest range to each beacon, if it is not too old.
    std::vector<RangeObservation> near(int robot, Nanoseconds time) const;

private:
    struct Received {
        bool has_receiver = false;
        std::vector<RangeObservation> newest;  // of each beacon and receiver
    };
    std::vector<Received> robots_;  // as in the site
};

}  // namespace roomfix
