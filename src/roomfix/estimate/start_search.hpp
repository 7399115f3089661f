// Where a robot may be, from what its receivers and its detector said over a while and what its wheels said meanwhile: where tracking starts.
#pragma once

#include <span>
#include <string>
#include <variant>
#include <vector>

#include "roomfix/estimate/event.hpp"
#include "roomfix/estimate/tracking_models.hpp"

namespace roomfix {

/// What a robot heard or detected.
using Heard = std::variant<RangeObservation, RangeDifferenceObservation, SightingObservation>;

Nanoseconds time_of(const Heard& heard);

struct StartPlaces {
    std::vector<PlaceProposal> places;  // at the time of the newest that was heard; the likeliest first, weights add up to 1
    double error = 0;                   // m: what is left over at the likeliest place, one standard deviation
    double bias = 0;                    // m: by how much its ranges are too long, all alike
    std::string reason;                 // why there are none
};

/// `heard` in the order of its times; `patience`: s after which a start is good enough though the front is unknown or several places are left. How large the
/// errors are is found along with the place: nothing that is stated of them is believed. Places are sought on a grid over all that is in reach, and refined from
/// its best cells by robust least squares (Student's t distribution). Without wheels only what was heard within the last seconds counts.
StartPlaces search_start(std::span<const Heard> heard, int robot, const TrackingModels& models, double patience);

}  // namespace roomfix
