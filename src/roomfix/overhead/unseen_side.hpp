// A robot that shows less than its width: which of its sides is the one that is not seen?
#pragma once

#include <span>
#include <vector>

#include "roomfix/observation/pose_observation.hpp"
#include "roomfix/overhead/outline_fit.hpp"

namespace roomfix {

struct UnseenSideSettings {
    double narrower = 1.5;     // px by which the foreground must be narrower than the outline
    double hidden = 0.1;       // probability that something hides a side
    double least_seen = 0.2;   // part of the width that must be seen
    double side_shown = 0.7;   // part of both sides at which edges are where the outline has them: it is as wide as the robot
    double surprising = 4.5;   // nats by which the whole outline may stand off where it is expected, for that to be so
    double least_shown = 0.5;  // part of the outline that must show an edge, of what is not hidden
};

/// Something of which nobody knows may hide the left or right side, or it looks as the floor does; and what is taken for the robot's own side may be the border
/// of what hides it. Where the foreground is narrower than the robot's outline, the robot is fitted once more with either side hidden. The likeliest fit is
/// given, by the edges that it explains and by where the robot is `expected` (null: nobody knows); its covariance is as wide as they lie apart, each as far as
/// it is as likely. Upper and lower sides are left alone: what robots have there, wheels and loads, is seldom as described.
OutlineFit weigh_unseen_sides(const FrameEvidence& evidence, const View& view, std::span<const ShapePoints> parts, const OutlineFit& fit,
                              const std::vector<Silhouette>& others, const PoseObservation* expected, const OutlineFitSettings& fitting,
                              const UnseenSideSettings& settings = {});

}  // namespace roomfix
