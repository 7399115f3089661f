// Light's contrast along an edge, piece by piece: where does the edge end and something nearly in line with it begin?
#pragma once

#include <cstddef>

#include "roomfix/base/fixed_list.hpp"

namespace roomfix {

/// Light's step across a piece of an edge; weight is one over its variance, 0 if it was not read.
struct PieceContrast {
    double contrast = 0, weight = 0;
};
using EdgeContrasts = FixedList<PieceContrast, 128>;

struct ContrastChange {
    double within = 48;    // px: an edge whose contrast changes within this ...
    double plainer = 2.5;  // ... to more than so many times as much, or turns around, goes on as something else ...
    double certain = 8;    // ... if it does by so many standard deviations
};

/// Of pieces first..last-1 together, each by its certainty.
PieceContrast mean_of(const EdgeContrasts& pieces, std::size_t first, std::size_t last);

/// How many pieces, from the first on, belong to the edge. A cupboard in a corner hides the lower part of the edge between the walls and
/// its own edge goes on nearly in line with it, but not with the same contrast. `length`: px, of a piece.
std::size_t pieces_before_change(const EdgeContrasts& pieces, double length, const ContrastChange& change);

}  // namespace roomfix
