// A robot's own senses, its receivers and its detector: where they find it, and what becomes of it where they contradict that.
#pragma once

#include <optional>
#include <string>

#include "roomfix/estimate/track.hpp"

namespace roomfix {

/// Keeps what a robot heard. False where it is not to be taken in: nobody knows yet where the robot is. As soon as that can be told the track starts there.
bool hear(Track& track, const RangeObservation& o, const TrackingModels& models);
bool hear(Track& track, const RangeDifferenceObservation& o, const TrackingModels& models);
bool hear(Track& track, const SightingObservation& o, const TrackingModels& models);

/// What one of its senses said was right with this probability. Where they go on to contradict where it should be, it is sought anew.
void note_agreement(Track& track, double right, const TrackingModels& models);

/// Nobody vouches for the wheels of a robot that its own senses found: both scales may be off a lot.
void doubt_wheels(OdometryPrior& wheels);

/// Are the ranges of its own senses depths, by what was learned?
bool sees_depths(const Track& track);

/// The track as it would be had its senses put it elsewhere when it was started. `depth`: its ranges are depths.
Track started_elsewhere(const Track& track, const PlaceProposal& place, bool depth, const TrackingModels& models);

/// How a slow error of the robot's own senses is distributed by what was learned, and how fast it changes along the way.
struct LearnedError {
    double sigma = 0;      // of its value when nothing is known
    double per_metre = 0;  // 1/m
};
/// Nothing if it is no such error.
std::optional<LearnedError> learned_error(const SlowState& slow, const Track& track, const TrackingModels& models);

/// Why a robot that was heard has not been found yet, in words.
std::string why_not_found(const Track& track, const TrackingModels& models);

}  // namespace roomfix
