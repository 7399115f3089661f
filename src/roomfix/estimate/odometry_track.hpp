// The dead-reckoned poses of one robot, as steps between any two times.
#pragma once

#include <optional>
#include <vector>

#include "roomfix/base/time.hpp"
#include "roomfix/estimate/motion.hpp"

namespace roomfix {

struct OdometryLimits {
    double longest_gap = 1.0;  // s between two poses that belong together
    double fastest = 15;       // m/s: a faster jump is a restarted odometry
    double fastest_turn = 20;  // rad/s
};

class OdometryTrack {
public:
    explicit OdometryTrack(const OdometryLimits& limits = {}) : limits_(limits) {}

    /// Takes poses in any order. Returns the time from which on steps have changed; nothing for a pose whose time is already there.
    std::optional<Nanoseconds> add(Nanoseconds time, const Pose2& pose);

    /// The first piece of way from `from` on: a step that ends at `to` or earlier, or no step where the odometry is silent.
    struct Piece {
        Nanoseconds end = 0;
        bool driven = false;  // false: odometry says nothing about this piece
        OdometryStep step;
    };
    Piece piece(Nanoseconds from, Nanoseconds to) const;
    /// The whole stretch between two times; nothing where the odometry is silent for a part of it.
    std::optional<OdometryStep> step(Nanoseconds from, Nanoseconds to) const;

    bool empty() const { return poses_.empty(); }
    Nanoseconds newest_time() const { return poses_.back().time; }
    /// Drops what lies before a time, but for the last pose before it.
    void forget_before(Nanoseconds time);

private:
    struct Stamped {
        Nanoseconds time;
        Pose2 pose;
    };
    bool connected(const Stamped& a, const Stamped& b) const;

    OdometryLimits limits_;
    std::vector<Stamped> poses_;  // in the order of their times
};

}  // namespace roomfix
