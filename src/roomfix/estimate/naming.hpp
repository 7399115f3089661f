// Which of several robots that look alike a new track is: it gets a name when looks, wheels or tags have told.
#pragma once

#include "roomfix/estimate/open_names.hpp"

namespace roomfix {

constexpr std::size_t most_associations = 32;

/// Sets Association::open without a change of the weight: what a track that has just ended added to it stays.
void keep_open(Association& association, Nanoseconds time, const Group& group, const TrackingModels& models);

/// Tracks of an association that were seen often enough get the names of robots that may be elsewhere than they are thought to be: one association for each
/// likely way to do it, among them that a track is no robot of the group at all. All that can be named at once are: names exclude each other.
void give_names(GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models);

}  // namespace roomfix
