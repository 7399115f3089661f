#include <algorithm>
#include <cstdlib>

#include "roomfix/imaging/background_rows.hpp"

namespace roomfix::scalar {
namespace {

/// The background as the frame's light makes it: mean * gain, at most 255.
int predicted(const BackgroundRow& row, int x) {
    const std::uint32_t fine = (std::uint32_t{row.mean[x]} << 6) + 32;
    return static_cast<int>(std::min((fine * row.gain[x >> 6]) >> 16, 255U));
}

}  // namespace

void classify_row(const BackgroundRow& row, std::uint64_t* words) {
    for (int w = 0; w < row.words; ++w) {
        std::uint64_t bits = 0;
        for (int i = 0; i < 64; ++i) {
            const int x = w * 64 + i;
            bits |= static_cast<std::uint64_t>(std::abs(row.frame[x] - predicted(row, x)) > row.limit[x]) << i;
        }
        words[w] = bits;
    }
}

void shadow_row(const simd::ShadowRow& shadow_row, int first, int last, const std::uint64_t* foreground, std::uint64_t* shadow) {
    const BackgroundRow& row = shadow_row.row;
    for (int w = first; w < last; ++w) {
        std::uint64_t bits = 0;
        for (int i = 0; i < 64 && foreground[w]; ++i) {
            const int x = w * 64 + i;
            const int expected = predicted(row, x);
            const bool darker = row.frame[x] < expected && row.frame[x] >= (expected * 256 * shadow_row.darkest) >> 24;
            // Steps of two pixels, across and down: a shadow adds no structure of its own.
            const int ahead = std::min(x + 2, row.words * 64 - 1);
            const int behind = std::max(x - 2, 0);
            const int step_x = std::abs(row.frame[ahead] - row.frame[behind]);
            const int known_x = std::abs(row.mean[ahead] - row.mean[behind]);
            const int step_y = std::abs(shadow_row.frame_below[x] - shadow_row.frame_above[x]);
            const int known_y = std::abs(shadow_row.mean_below[x] - shadow_row.mean_above[x]);
            const bool plain = step_x <= std::min(known_x + row.limit[x], 255) && step_y <= std::min(known_y + row.limit[x], 255);
            bits |= static_cast<std::uint64_t>(darker && plain) << i;
        }
        shadow[w] = bits & foreground[w];
    }
}

void block_sums(const BlockRows& rows, PairSum* sums) {
    for (int w = 0; w < rows.words; ++w) {
        sums[w] = {0, 0};
        for (int r = 0; r < rows.count; ++r) {
            for (int i = 0; i < 64; ++i) {
                sums[w].frame += rows.frame[r][w * 64 + i];
                sums[w].background += rows.mean[r][w * 64 + i];
            }
        }
    }
}

void refresh_row(const RefreshRow& row) {
    for (int x = 0; x < row.words * 64; ++x) {
        if ((row.keep[x >> 6] >> (x & 63)) & 1U) continue;
        const std::uint32_t frame = std::uint32_t{row.frame[x]} << 8;
        const int half = static_cast<int>((frame * row.inverse_gain[x >> 6]) >> 16);
        const int light = std::min(2 * half, 65535);
        const int mean = row.mean_fine[x];
        const int off = std::abs(light - mean);
        row.mean_fine[x] = static_cast<std::uint16_t>(mean + (light > mean ? off >> row.mean_shift : -(off >> row.mean_shift)));
        const int deviation = row.deviation[x];
        const int usual = std::min(off, 16 << 8);
        row.deviation[x] = static_cast<std::uint16_t>(usual > deviation ? deviation + ((usual - deviation) >> row.noise_shift)
                                                                        : deviation - ((deviation - usual) >> row.noise_shift));
        row.mean[x] = static_cast<std::uint8_t>(std::min(row.mean_fine[x] + 128, 65535) >> 8);
        row.limit[x] = static_cast<std::uint8_t>(std::min(row.limit_floor + ((row.deviation[x] * row.limit_factor) >> 16) + (row.mean[x] >> 6), 255));
    }
}

}  // namespace roomfix::scalar
