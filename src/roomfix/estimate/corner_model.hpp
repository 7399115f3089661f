// A room's corner as a camera on the robot sees it: its turn against the corner and its place up to scale.
#pragma once

#include "roomfix/estimate/landmark_model.hpp"
#include "roomfix/observation/corner_observation.hpp"

namespace roomfix {

/// Prepares the slow states of the mount's and the time's errors, and of the corner's place. `number`: its index in the site.
void add_slow_states(Belief& belief, int number, const OnboardSource& source, const TimeError& error);

/// `number`: the corner's index in the site, for the error of its position. Residual: rotation about the corner's x, y, z (rad), then place. Nothing for a
/// camera at or above the corner.
std::optional<Linearised<5>> linearise_corner(const Belief& belief, const CornerObservation& seen, const SiteCorner& corner, int number,
                                              const OnboardSource& source);

/// Takes a corner into the belief, linearised again where needed.
std::optional<Innovation> update_corner(Belief& belief, const CornerObservation& seen, const SiteCorner& corner, int number, const OnboardSource& source,
                                        const OutlierModel& outliers);

}  // namespace roomfix
