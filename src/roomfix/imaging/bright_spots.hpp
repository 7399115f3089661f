// Small bright things on a darker ground: one pass of SIMD compares over the frame.
#pragma once

#include <cstddef>
#include <cstdint>

#include "roomfix/imaging/bit_mask.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct BrightSpotSettings {
    int threshold = 100;  // grey levels: darker pixels are never part of a spot
    int contrast = 50;    // grey levels that a spot stands out
    int reach = 4;        // px: at this distance ...
    // ... at least three of the four neighbours (left, right, above, below) must be darker by `contrast`. So a lamp longer or wider
    // than `reach` holds no spot but perhaps at its ends, and a spot right beside a lamp is still one.
};

/// Sets the pixels of `spots` that belong to small bright spots. A border of `reach` pixels (one more at the bottom) stays empty.
/// No allocation if `spots` has the frame's size already.
void find_bright_spots(LumaView frame, const BrightSpotSettings& settings, BitMask& spots);

/// Rows y - reach to y + reach must exist; 64 * words columns and `reach` more on both sides must be readable.
struct BrightRow {
    const std::uint8_t* pixels;
    std::ptrdiff_t stride;
    int words;
    BrightSpotSettings settings;
};
namespace simd {
void bright_row(const BrightRow& row, std::uint64_t* words);
}
namespace scalar {
void bright_row(const BrightRow& row, std::uint64_t* words);
}

}  // namespace roomfix
