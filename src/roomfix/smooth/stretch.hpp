// One robot's way over a stretch of time, fitted to all that was measured of it.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "roomfix/estimate/tracker.hpp"
#include "roomfix/smooth/knot_covariance.hpp"
#include "roomfix/smooth/smoother_settings.hpp"
#include "roomfix/smooth/trajectory.hpp"

namespace roomfix {

/// One for each robot of the site that has one.
using Trajectories = std::vector<std::optional<Trajectory>>;

struct SmoothingTask {
    int robot;
    const TrackerHistory& history;
    const std::vector<Group>& groups;
    const TrackingModels& models;
    const SmootherSettings& settings;
};

/// A slow error as it was estimated along.
struct SlowEstimate {
    std::optional<SlowState> state;  // nothing: the wheels' scale or drift
    double value = 0;
};

/// Observations of one source.
struct SightingCount {
    int all = 0;
    int doubted = 0;  // that contradict everything else, and have no say
};

struct SmoothedStretch {
    Trajectory trajectory;
    SmoothedCovariance covariance;        // of the knots, and of `slow` in its order
    std::vector<SlowEstimate> slow;       // a value for each long while over which it was taken for constant; without what changes within seconds
    std::map<int, SightingCount> counts;  // by source
    bool settled = true;                  // nothing is explained worse than by the start
};

/// Where the tracker saw each robot go, with knots where something was measured: a start for smoothing. `tracked`: its fixes, in the order
/// of their times. Robots that are one of many have none, nor have those with fewer than two fixes.
Trajectories first_trajectories(const Tracker& tracker, const std::vector<Fix>& tracked, const SmootherSettings& settings);

/// First with hardly any observation thrown out, so that a start that is off can move; then with the tracker's own doubts; in the end
/// with each source's noise as it turned out. `others`: where the other robots are. `progress` gets 0..1.
SmoothedStretch smooth_stretch(const SmoothingTask& task, const Trajectory& start, const Trajectories& others,
                               const std::function<void(double)>& progress = {});

}  // namespace roomfix
