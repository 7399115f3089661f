// What a sensor states for a distance: longer or shorter by a constant part, and by the direction in which it looks.
#pragma once

#include <array>
#include <cmath>

#include "roomfix/estimate/update.hpp"

namespace roomfix {

/// Errors of all ranges of one sensor that grow with the range. Zero: there is no such error.
struct StretchErrors {
    double depth = 0;      // 0: ranges are distances; 1: only how far ahead of the robot something is, as cameras measure by sizes
    double scale = 0;      // part of the range, standard deviation
    double direction = 0;  // ... of what depends on the direction besides
    double curve = 0;      // 1/m, of what grows with the square of the range
    double growth = 0;     // ... of what is new in every range
};

/// Standard deviation of a range, m. `sigma`: m, of a short one.
inline double grown(double sigma, const StretchErrors& errors, double range) { return std::hypot(sigma, errors.growth * range); }

/// Prepares the slow states. `source`: the receiver's number or `of_detector`; `forget`: 1/s.
void add_slow_states(Belief& belief, int source, const StretchErrors& errors, double forget);

/// A stated range, and its derivatives.
struct StretchedRange {
    double value = 0;                     // m
    double by_range = 1, by_bearing = 0;  // 1, m/rad
    FixedList<int, 4> states;             // slow states that it depends on ...
    std::array<double, 4> by_state{};     // ... and how, m
    double noise = 0;                     // m^2, variance of errors without a state
};
/// `range`: m, the distance; `bearing`: rad, from the robot's front, counterclockwise.
StretchedRange stretched(const Belief& belief, int source, const StretchErrors& errors, double range, double bearing);

}  // namespace roomfix
