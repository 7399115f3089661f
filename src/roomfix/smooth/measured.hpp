// Observations of one robot, each with what it shows decided.
#pragma once

#include <functional>
#include <variant>
#include <vector>

#include "roomfix/estimate/tracker.hpp"
#include "roomfix/smooth/trajectory.hpp"

namespace roomfix {

struct SeenLandmark {
    LandmarkObservation seen;
    int landmark = 0;  // index in the site
};

struct SeenCorner {
    CornerObservation seen;  // as a picture of the site's corner
    int corner = 0;          // index in the site
};

struct SeenMark {
    SightingObservation seen;
    int landmark = 0;  // index in the site
};

struct Measured {
    Nanoseconds time = 0;
    int source = 0;  // of the tracker's sources
    std::variant<PoseObservation, TagSighting, SeenLandmark, SeenCorner, SeenMark, RangeObservation, RangeDifferenceObservation> what;
};

/// What a source saw or heard, where it can be one of several things: the landmark, corner or beacon; 0 otherwise.
int thing_of(const Measured& measured);

/// Adds to the belief where a robot is what is known of the errors of its own senses at a time.
using KnownErrors = std::function<void(Belief&, Nanoseconds)>;

/// Where the other robots of the group are is needed to tell look-alikes apart: `trajectories` has one for each robot of the site that has
/// one. What fits the trajectory of `robot` best is what was seen; observations that fit nothing are left out.
std::vector<Measured> measured_of(int robot, const TrackerHistory& history, const std::vector<Group>& groups, const TrackingModels& models,
                                  const std::vector<std::optional<Trajectory>>& trajectories, const KnownErrors& known = {});

}  // namespace roomfix
