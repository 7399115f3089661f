// Exponential and logarithm of floats, such that loops over them run several values at once.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace roomfix {

/// exp(x), relative error below 3e-6, for x from -87 to 88; beyond, the value at that end.
inline float fast_exp(float x) {
    constexpr float log2_e = 1.44269504f;
    const float y = (x < -87.0f ? -87.0f : x > 88.0f ? 88.0f : x) * log2_e;
    const float whole = std::floor(y);
    const float f = y - whole;
    // 2^f on 0..1: Taylor's series around the middle, in Horner's form.
    const float t = (f - 0.5f) * 0.69314718f;
    const float part = 1.41421356f * (1 + t * (1 + t * (0.5f + t * (0.16666667f + t * (0.041666667f + t * 0.0083333333f)))));
    return part * std::bit_cast<float>((static_cast<std::int32_t>(whole) + 127) << 23);
}

/// ln(x) of a normal positive number, absolute error below 3e-6.
inline float fast_log(float x) {
    const auto bits = std::bit_cast<std::int32_t>(x);
    // The mantissa between sqrt(1/2) and sqrt(2).
    const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;
    const float m = std::bit_cast<float>(bits - exponent * (1 << 23));
    // ln m = 2 artanh((m - 1) / (m + 1)).
    const float z = (m - 1) / (m + 1);
    const float zz = z * z;
    return static_cast<float>(exponent) * 0.69314718f + 2 * z * (1 + zz * (0.33333333f + zz * (0.2f + zz * (0.14285714f + zz * 0.11111111f))));
}

}  // namespace roomfix
