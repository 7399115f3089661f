// When the rows of a picture are exposed, where a camera exposes one after another (rolling shutter).
#pragma once

namespace roomfix {

/// How much later than the picture's middle row a row is exposed, s; negative for rows above it. `readout`: s from the first row's exposure to the last
/// row's.
constexpr double row_time(double readout, int rows, double row) { return rows > 0 ? readout * ((row + 0.5) / rows - 0.5) : 0; }

}  // namespace roomfix
