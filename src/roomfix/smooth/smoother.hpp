// The best way of every robot after the fact: all observations of a session at once, those that came later, too.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "roomfix/estimate/tracker.hpp"
#include "roomfix/smooth/smoother_settings.hpp"

namespace roomfix {

/// A while for which the batch explains what was measured worse than its start did: it did not settle.
struct Unsettled {
    std::string robot;
    Nanoseconds from = 0, to = 0;
};

struct Smoothed {
    std::vector<Fix> fixes;
    std::vector<Unsettled> unsettled;  // there the fixes are the tracker's
};

/// `tracked`: the tracker's fixes, in the order of their times. Returns the same fixes, with the smoothed poses and their covariances:
/// a fix of status none becomes a known one where what came later tells, and a known one none where all together does not tell it.
/// Robots that are one of many, and those with fewer than two fixes, stay as they are. The same input gives the same output.
/// `progress` gets 0..1.
/// Source: batch maximum a posteriori over a continuous trajectory (Barfoot, Tong and Särkkä 2014), solved by Levenberg-Marquardt.
Smoothed smooth(const Tracker& tracker, const std::vector<Fix>& tracked, const SmootherSettings& settings = {},
                const std::function<void(double)>& progress = {});

}  // namespace roomfix
