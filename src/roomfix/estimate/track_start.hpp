// Where a track begins, or begins anew: places become hypotheses.
#pragma once

#include <vector>

#include "roomfix/estimate/track.hpp"

namespace roomfix {

/// What is believed of a robot that was found at a place. Nothing is known of how it moves.
Belief start_belief(const PlaceProposal& place, int robot, const TrackingModels& models);

/// Places become hypotheses with a weight of `share` together; one without a yaw is tried in all directions where odometry could tell them apart.
void add_places(Track& track, const std::vector<PlaceProposal>& places, double share, const TrackingModels& models);

/// Starts a track, or starts it anew, at one of several places.
void start(Track& track, const std::vector<PlaceProposal>& places, Nanoseconds time, const TrackingModels& models);

/// The places that a sighting allows: all poses that look alike.
void list_places(const PoseObservation& observation, const PoseSource& source, std::vector<PlaceProposal>& places);
std::vector<PlaceProposal> places_of(const PoseObservation& observation, const PoseSource& source);

}  // namespace roomfix
