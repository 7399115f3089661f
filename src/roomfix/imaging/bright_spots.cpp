#include "roomfix/imaging/bright_spots.hpp"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "roomfix/imaging/bright_spots.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace roomfix {
namespace HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR
void BrightRowBits(const BrightRow& row, std::uint64_t* words) { scalar::bright_row(row, words); }
#else
namespace hn = hwy::HWY_NAMESPACE;

// At most one word of the mask per vector, so that every target walks the same 64-pixel blocks.
using Bytes = hn::CappedTag<std::uint8_t, 64>;
constexpr Bytes bytes;

HWY_INLINE hn::Mask<Bytes> at_least(hn::Vec<Bytes> value, hn::Vec<Bytes> limit) { return hn::Eq(hn::Max(value, limit), value); }

/// Most words hold nothing bright: one compare tells.
void BrightRowBits(const BrightRow& row, std::uint64_t* words) {
    const int lanes = static_cast<int>(hn::Lanes(bytes));
    const auto threshold = hn::Set(bytes, static_cast<std::uint8_t>(row.settings.threshold));
    const auto contrast = hn::Set(bytes, static_cast<std::uint8_t>(row.settings.contrast));
    const std::ptrdiff_t down = row.settings.reach * row.stride;
    for (int w = 0; w < row.words; ++w) {
        std::uint64_t word = 0;
        for (int i = 0; i < 64; i += lanes) {
            const std::uint8_t* p = row.pixels + w * 64 + i;
            const auto here = hn::LoadU(bytes, p);
            const auto bright = at_least(here, threshold);
            if (HWY_LIKELY(hn::AllFalse(bytes, bright))) continue;
            const auto stands_out = [&](std::ptrdiff_t offset) { return at_least(hn::SaturatedSub(here, hn::LoadU(bytes, p + offset)), contrast); };
            const auto left = stands_out(-row.settings.reach);
            const auto right = stands_out(row.settings.reach);
            const auto above = stands_out(-down);
            const auto below = stands_out(down);
            const auto three = hn::Or(hn::And(hn::And(left, right), hn::Or(above, below)), hn::And(hn::And(above, below), hn::Or(left, right)));
            alignas(8) std::uint8_t bits[8] = {};
            hn::StoreMaskBits(bytes, hn::And(bright, three), bits);
            std::uint64_t part;
            std::memcpy(&part, bits, 8);
            word |= part << i;
        }
        words[w] = word;
    }
}
#endif

}  // namespace HWY_NAMESPACE
}  // namespace roomfix
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace roomfix {

HWY_EXPORT(BrightRowBits);

void simd::bright_row(const BrightRow& row, std::uint64_t* words) { HWY_DYNAMIC_DISPATCH(BrightRowBits)(row, words); }

void scalar::bright_row(const BrightRow& row, std::uint64_t* words) {
    const BrightSpotSettings& s = row.settings;
    const std::ptrdiff_t down = s.reach * row.stride;
    for (int w = 0; w < row.words; ++w) {
        std::uint64_t bits = 0;
        for (int i = 0; i < 64; ++i) {
            const std::uint8_t* p = row.pixels + w * 64 + i;
            if (*p < s.threshold) continue;
            const auto stands_out = [&](std::ptrdiff_t offset) { return std::max(*p - p[offset], 0) >= s.contrast; };
            const int sides = stands_out(-s.reach) + stands_out(s.reach) + stands_out(-down) + stands_out(down);
            bits |= static_cast<std::uint64_t>(sides >= 3) << i;
        }
        words[w] = bits;
    }
}

void find_bright_spots(LumaView frame, const BrightSpotSettings& settings, BitMask& spots) {
    if (spots.width() != frame.width || spots.height() != frame.height) spots.resize(frame.width, frame.height);
    const int reach = settings.reach;
    const bool small = frame.stride < 64 + 2 * reach || frame.width <= 2 * reach;  // a word might reach beyond the next row
    for (int y = 0; y < frame.height; ++y) {
        std::uint64_t* words = spots.row(y);
        spots.span(y) = {};
        if (small || y < reach || y >= frame.height - reach - 1) {
            std::fill_n(words, spots.words(), 0);
            continue;
        }
        simd::bright_row({frame.row(y), frame.stride, spots.words(), settings}, words);
        // Columns near the border have a neighbour in another row.
        const auto first = ~0ULL << reach;
        words[0] &= first;
        const int last = frame.width - reach;  // first column that is too far to the right
        for (int w = last / 64; w < spots.words(); ++w) words[w] &= w > last / 64 ? 0 : (1ULL << (last % 64)) - 1;
        WordSpan& span = spots.span(y);
        for (int w = 0; w < spots.words(); ++w) {
            if (!words[w]) continue;
            if (span.empty()) span.first = w;
            span.last = w + 1;
        }
    }
}

}  // namespace roomfix
#endif
