// The inner loop of the spot fit: what a model of a spot makes of its pixels, as SIMD with run-time dispatch.
#pragma once

#include <array>

namespace roomfix {

/// The pixels that count, as columns; `count` is padded to a multiple of 16 with pixels of weight 0.
struct SpotPixels {
    static constexpr int capacity = 240;
    int count = 0;
    alignas(64) std::array<float, capacity> x;  // px from the window's middle
    alignas(64) std::array<float, capacity> y;
    alignas(64) std::array<float, capacity> grey;    // grey levels
    alignas(64) std::array<float, capacity> weight;  // 1, or 0 for padding
};

/// u, v: px from the window's middle; light: 1 = grey level 255.
struct SpotModel {
    float u, v, amplitude, steepness, ground, slope_x, slope_y;
    float gamma;
    float read_variance, shot_noise;  // grey levels^2, grey levels^2 per grey level
    float saturated;                  // grey level
    float huber;                      // standard deviations
};

/// Lower triangle of the weighted normal matrix, row by row (28), the gradient (7) and the robust cost of the unknowns u, v, log of
/// the amplitude, steepness, ground, slope_x, slope_y.
struct SpotSums {
    std::array<float, 28> normal;
    std::array<float, 7> gradient;
    float cost;
};

namespace simd {
void spot_sums(const SpotPixels& pixels, const SpotModel& model, SpotSums& sums);
}
namespace scalar {
void spot_sums(const SpotPixels& pixels, const SpotModel& model, SpotSums& sums);
}

}  // namespace roomfix
