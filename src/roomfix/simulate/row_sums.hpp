// Weighted sums of whole rows of pixels, several of which go through the processor at once.
#pragma once

#include <cstddef>

namespace roomfix {

/// to += scale * from
inline void add_scaled(float scale, const float* from, std::size_t count, float* to) {
    for (std::size_t i = 0; i < count; ++i) to[i] += scale * from[i];
}

/// to += (scale * from + second_scale * second)
inline void add_scaled(float scale, const float* from, float second_scale, const float* second, std::size_t count, float* to) {
    for (std::size_t i = 0; i < count; ++i) to[i] += scale * from[i] + second_scale * second[i];
}

}  // namespace roomfix
