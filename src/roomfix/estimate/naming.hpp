// Which of several robots that look alike a new track is: it gets a name when looks, wheels or tags have told.
#pragma once

#include "roomfix/estimate/group.hpp"

namespace roomfix {

constexpr std::size_t most_associations = 32;
constexpr double no_robot = 0.03;  // share of new tracks that are none of the group

/// Is every robot of the group likelier where the association has it than anywhere else?
bool all_followed(const Association& association, Nanoseconds time, const Group& group, const TrackingModels& models);

/// A track without a name is followed as each of the robots, too, whose wheels will tell.
void propose_name(Track& track, int robot, const TrackingModels& models);

/// Tracks of an association that were seen often enough get the names of robots that may be elsewhere than they are thought to be: one association for each
/// likely way to do it, among them that a track is no robot of the group at all. All that can be named at once are: names exclude each other.
void give_names(GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models);

}  // namespace roomfix
