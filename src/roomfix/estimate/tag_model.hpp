// The corners of a tag on a robot, in the pixels of a fixed camera.
#pragma once

#include "roomfix/estimate/update.hpp"
#include "roomfix/geometry/view.hpp"
#include "roomfix/observation/landmark_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// `seen`: bottom left, bottom right, top right, top left corner, as the tag is read (own_points()). The view's calibration is part of
/// the noise. Nothing where a corner is out of sight.
std::optional<Linearised<8>> linearise_tag(const Belief& belief, const FixedList<PointSighting, 4>& seen, const View& view, const SiteRobot& robot);

}  // namespace roomfix
