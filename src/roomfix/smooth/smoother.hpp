// The best way of every robot after the fact: all observations of a session at once, those that came later, too.
#pragma once

#include <functional>
#include <vector>

#include "roomfix/estimate/tracker.hpp"

namespace roomfix {

struct SmootherSettings {
    Nanoseconds step = 100'000'000;    // at most between two knots
    Nanoseconds closest = 10'000'000;  // knots, at least apart
    double window = 120;               // s that are smoothed at once; 0: the whole session
    double overlap = 5;                // s more on either side of a window, that are then left to its neighbours
    int most_iterations = 30;
};

/// `tracked`: the tracker's fixes, in the order of their times. Returns the same fixes, with the smoothed poses and their covariances:
/// a fix of status none becomes a known one where what came later tells. Robots that are one of many, and those with fewer than two
/// fixes, stay as they are. The same input gives the same output. `progress` gets 0..1.
/// Source: batch maximum a posteriori over a continuous trajectory (Barfoot, Tong and Särkkä 2014), solved by Levenberg-Marquardt.
std::vector<Fix> smooth(const Tracker& tracker, const std::vector<Fix>& tracked, const SmootherSettings& settings = {},
                        const std::function<void(double)>& progress = {});

}  // namespace roomfix
