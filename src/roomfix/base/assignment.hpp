// Who is who: the cheapest way to pair rows with columns where not every pair is allowed.
#pragma once

#include <vector>

namespace roomfix {

/// A pair that may be, with its cost; lower is better.
struct PossiblePair {
    int row = 0;
    int column = 0;
    double cost = 0;
};

/// The column of each row, -1: none. A row without a column costs `alone`. Minimises the sum over all rows exactly; work grows with the
/// size of the groups of rows that compete, not with the number of all rows.
/// Source: shortest augmenting paths (Jonker and Volgenant 1987).
std::vector<int> assign(int rows, int columns, const std::vector<PossiblePair>& pairs, double alone);

}  // namespace roomfix
