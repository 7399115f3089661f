// A robot's way: knots of pose and velocity, and cubic pieces between them.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "roomfix/base/time.hpp"
#include "roomfix/estimate/motion.hpp"
#include "roomfix/estimate/odometry_track.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix {

/// x, y, yaw in the map and their rates; m, rad, s. The yaw goes on beyond half a turn, so that neighbours never differ by a whole one.
using Knot = Vector6d;

/// How pose and rate at one time follow from the two knots around it: rows pose, rate; columns pose and rate before, pose and rate after.
using KnotWeights = Eigen::Matrix<double, 2, 4>;
/// `part` 0..1 of the `seconds` between the knots. Source: cubic Hermite interpolation, the mean of white noise on the acceleration
/// (Barfoot, Tong and Särkkä 2014).
KnotWeights knot_weights(double part, double seconds);
Knot between(const Knot& before, const Knot& after, const KnotWeights& weights);

struct Trajectory {
    std::vector<Nanoseconds> times;  // strictly rising
    std::vector<Knot> knots;         // at these times, two or more

    Nanoseconds start() const { return times.front(); }
    Nanoseconds end() const { return times.back(); }
    bool covers(Nanoseconds time) const { return time >= start() && time <= end(); }
    /// The knot before a time that is covered, never the last one.
    std::size_t knot_before(Nanoseconds time) const;
    double seconds_after(std::size_t knot) const { return to_seconds(times[knot + 1] - times[knot]); }
    /// Of a time between a knot and the next: 0..1, and how the state there follows from both.
    double part_in(std::size_t knot, Nanoseconds time) const;
    KnotWeights weights_in(std::size_t knot, Nanoseconds time) const;
    Knot at(Nanoseconds time) const;
    /// The knots from the last not after `from` to the first not before `to`.
    Trajectory part(Nanoseconds from, Nanoseconds to) const;
};

/// Times for knots: where something was measured, but not closer than `closest`, and in between so that no gap is longer than `step`.
std::vector<Nanoseconds> knot_times(std::vector<Nanoseconds> measured, Nanoseconds step, Nanoseconds closest);

/// The way as far as the tracker knew it, as a start for smoothing: `fixes` of one robot in the order of their times. Where it knew none,
/// wheels fill in, from later on backwards, and straight lines otherwise. `like_turns`: so many turns in a circle look the same; the front
/// is the one that the tracker ended with. Nothing with fewer than two known fixes, or times.
std::optional<Trajectory> first_trajectory(const std::vector<Fix>& fixes, const std::vector<Nanoseconds>& times, const OdometryTrack& driven, int like_turns);

}  // namespace roomfix
