// The corners of a tag on a robot, in the pixels of a fixed camera.
#pragma once

#include "roomfix/estimate/pose_model.hpp"
#include "roomfix/geometry/view.hpp"
#include "roomfix/observation/landmark_observation.hpp"
#include "roomfix/observation/time_error.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// `seen`: bottom left, bottom right, top right, top left corner, as the tag is read (own_points()). The error of the view's pose
/// belongs to the slow states, or is noise where there are none. Nothing where a corner is out of sight.
std::optional<Linearised<8>> linearise_tag(const Belief& belief, const FixedList<PointSighting, 4>& seen, const View& view, const SiteRobot& robot,
                                           const PoseSource& source, const TimeError& error);

}  // namespace roomfix
