// A moulding draws two edges on a wall, and either may be the one that was measured: both readings of what a picture shows.
#pragma once

#include <optional>

#include "roomfix/corner/parallel_edges.hpp"
#include "roomfix/observation/corner_observation.hpp"

namespace roomfix {

struct SeenMoulding {
    MouldingEdge read = MouldingEdge::none_seen;
    double rise = 0;        // of its other corner above the one that was read, in ceiling distances; below: negative
    double rise_sigma = 0;  // what its unknown profile leaves open
    bool one_wall = false;  // the other wall shows none
};

/// The moulding whose edges lie beside those that were read; nothing where there are none.
std::optional<SeenMoulding> moulding_beside(const EdgesBeside& edges, const CornerView& view, double wall_angle);

/// The other corner as if it had been read.
CornerObservation other_reading(const CornerObservation& seen, const SeenMoulding& moulding);

}  // namespace roomfix
