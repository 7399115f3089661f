// Noise that a place in space always has: textures.
#pragma once

#include <cstdint>

#include "roomfix/base/random.hpp"

namespace roomfix {

/// A number in -1..1 for each point of a lattice.
inline float lattice_noise(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t seed) {
    const std::uint64_t h = mix64(static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ULL ^ static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4fULL ^
                                  static_cast<std::uint64_t>(z) * 0x165667b19e3779f9ULL ^ seed);
    return static_cast<float>(h >> 40U) * 0x1p-23f - 1.0f;
}

}  // namespace roomfix
