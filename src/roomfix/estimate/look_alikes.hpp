// Sightings of robots that look alike go to their tracks; new tracks begin, lost ones end.
#pragma once

#include "roomfix/estimate/group.hpp"

namespace roomfix {

/// Takes one frame into every association; the tracks are at its time. Adds associations where robots may have been mixed up, or where a new robot may
/// be one of several.
void take_frame(GroupState& state, const GroupSighting& frame, const Event& event, const Group& group, const TrackingModels& models);

}  // namespace roomfix
