// The receivers of all robots: what each heard last, and where that alone puts it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "roomfix/estimate/event.hpp"
#include "roomfix/pipeline/onboard_locator.hpp"

namespace roomfix {

class RangeEars {
public:
    /// One ear for each robot with a receiver.
    static Result<RangeEars> create(const Site& site);

    bool empty() const { return ears_.empty(); }
    bool hears(int robot) const { return find(robot) != nullptr; }
    /// Takes a range if the robot has a receiver.
    void keep(const RangeObservation& range);
    /// The robot's newest range to each beacon, if it is not too old.
    std::vector<RangeObservation> near(int robot, Nanoseconds time) const;
    /// Where these ranges alone put the robot; nothing where they do not fix a place.
    std::optional<PlaceSighting> places(int robot, Nanoseconds time);

private:
    struct Ear {
        int robot = 0;
        std::unique_ptr<OnboardLocator> locator;
        std::vector<RangeObservation> heard;  // the newest of each beacon
        Nanoseconds located = 0;
    };
    const Ear* find(int robot) const;

    std::vector<Ear> ears_;
};

}  // namespace roomfix
