// The row kernels of the background model: SIMD with run-time dispatch, and the scalar version they must match bit for bit.
#pragma once

#include <cstddef>
#include <cstdint>

namespace roomfix {

/// Sums of 64 pixels of a row and of the background at the same place.
struct PairSum {
    std::uint32_t frame;
    std::uint32_t background;
};

/// Widths count pixels; frame, mean and limit rows must be readable up to the next multiple of 64. `gain` has one entry
/// per 64 pixels, 1024 = 1.
struct BackgroundRow {
    const std::uint8_t* frame;
    const std::uint8_t* mean;
    const std::uint8_t* limit;
    const std::uint16_t* gain;
    int words;
    std::ptrdiff_t ahead = 0;  // bytes from this row to the one that will be classified next
};

/// A few rows of frame and mean at the same places, for their sums over each 64 columns.
struct BlockRows {
    const std::uint8_t* frame[4];
    const std::uint8_t* mean[4];
    int count;
    int words;
};

struct RefreshRow {
    const std::uint8_t* frame;
    const std::uint64_t* keep;          // bit set: leave this pixel alone
    const std::uint16_t* inverse_gain;  // 32768 = 1
    std::uint16_t* mean_fine;
    std::uint16_t* deviation;
    std::uint8_t* mean;
    std::uint8_t* limit;
    int words;
    int mean_shift;
    int noise_shift;
    std::uint16_t limit_factor;  // limit = limit_floor + deviation * factor / 2^16 + mean / 64
    std::uint8_t limit_floor;
};

namespace simd {
/// Foreground bits of a row: |frame - mean * gain| > limit.
void classify_row(const BackgroundRow& row, std::uint64_t* words);
/// Shadow candidates among the foreground words first..last-1 of a row; `above` and `below` are the frame rows two lines
/// away (and of the mean), or the row itself at the border.
struct ShadowRow {
    BackgroundRow row;
    const std::uint8_t* frame_above;
    const std::uint8_t* frame_below;
    const std::uint8_t* mean_above;
    const std::uint8_t* mean_below;
    std::uint16_t darkest;  // of 65536
};
void shadow_row(const ShadowRow& row, int first, int last, const std::uint64_t* foreground, std::uint64_t* shadow);
void block_sums(const BlockRows& rows, PairSum* sums);
void refresh_row(const RefreshRow& row);
}  // namespace simd

namespace scalar {
void classify_row(const BackgroundRow& row, std::uint64_t* words);
void shadow_row(const simd::ShadowRow& row, int first, int last, const std::uint64_t* foreground, std::uint64_t* shadow);
void block_sums(const BlockRows& rows, PairSum* sums);
void refresh_row(const RefreshRow& row);
}  // namespace scalar

}  // namespace roomfix
