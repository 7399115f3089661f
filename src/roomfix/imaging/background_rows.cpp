#include "roomfix/imaging/background_rows.hpp"

#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "roomfix/imaging/background_rows.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace roomfix {
namespace HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR
// A processor without vectors: the kernels need lanes of two widths in one vector.
void ClassifyRow(const BackgroundRow& row, std::uint64_t* words) { scalar::classify_row(row, words); }
void ShadowRowBits(const simd::ShadowRow& row, int first, int last, const std::uint64_t* foreground, std::uint64_t* shadow) {
    scalar::shadow_row(row, first, last, foreground, shadow);
}
void BlockSums(const BlockRows& rows, PairSum* sums) { scalar::block_sums(rows, sums); }
void RefreshRowBits(const RefreshRow& row) { scalar::refresh_row(row); }
#else
namespace hn = hwy::HWY_NAMESPACE;

// At most one word of the mask per vector, so that every target walks the same 64-pixel blocks.
using Bytes = hn::CappedTag<std::uint8_t, 64>;
using Shorts = hn::Repartition<std::uint16_t, Bytes>;
constexpr Bytes bytes;
constexpr Shorts shorts;
using ByteVector = hn::Vec<Bytes>;
using ShortVector = hn::Vec<Shorts>;

HWY_INLINE ShortVector even_bytes(ByteVector v) { return hn::And(hn::BitCast(shorts, v), hn::Set(shorts, 0x00ff)); }
HWY_INLINE ShortVector odd_bytes(ByteVector v) { return hn::ShiftRight<8>(hn::BitCast(shorts, v)); }
HWY_INLINE ByteVector interleave(ShortVector even, ShortVector odd) { return hn::BitCast(bytes, hn::Or(even, hn::ShiftLeft<8>(odd))); }
HWY_INLINE ByteVector distance(ByteVector a, ByteVector b) { return hn::Or(hn::SaturatedSub(a, b), hn::SaturatedSub(b, a)); }
HWY_INLINE ShortVector distance(ShortVector a, ShortVector b) { return hn::Or(hn::SaturatedSub(a, b), hn::SaturatedSub(b, a)); }
HWY_INLINE hn::Mask<Bytes> exceeds(ByteVector value, ByteVector limit) { return hn::Ne(hn::SaturatedSub(value, limit), hn::Zero(bytes)); }

HWY_INLINE ShortVector lit(ShortVector mean, ShortVector gain) {
    const auto fine = hn::Add(hn::ShiftLeft<6>(mean), hn::Set(shorts, 32));
    return hn::Min(hn::MulHigh(fine, gain), hn::Set(shorts, 255));
}
/// mean * gain, at most 255.
HWY_INLINE ByteVector predicted(ByteVector mean, std::uint16_t gain) {
    const auto factor = hn::Set(shorts, gain);
    return interleave(lit(even_bytes(mean), factor), lit(odd_bytes(mean), factor));
}

HWY_INLINE std::uint64_t store_bits(hn::Mask<Bytes> mask) {
    alignas(8) std::uint8_t bits[8] = {};
    hn::StoreMaskBits(bytes, mask, bits);
    std::uint64_t word;
    std::memcpy(&word, bits, 8);
    return word;
}

/// A word at a time: a cheap test that errs on the side of foreground, the exact one only where that finds some. The exact
/// prediction mean * gain is mean + 128 (gain - 1) within 128 |gain - 1|.
void ClassifyRow(const BackgroundRow& row, std::uint64_t* words) {
    const int lanes = static_cast<int>(hn::Lanes(bytes));
    for (int w = 0; w < row.words; ++w) {
        const int shift = (row.gain[w] - 1024) / 8;
        const auto up = hn::Set(bytes, static_cast<std::uint8_t>(shift > 0 ? (shift < 255 ? shift : 255) : 0));
        const auto down = hn::Set(bytes, static_cast<std::uint8_t>(shift < 0 ? -shift : 0));
        const int width = (shift < 0 ? -shift : shift) + 2;
        const auto slack = hn::Set(bytes, static_cast<std::uint8_t>(width < 255 ? width : 255));
        // Three streams from memory: ask for the next row's part in time. Beyond the image this does nothing.
        hwy::Prefetch(row.frame + w * 64 + row.ahead);
        hwy::Prefetch(row.mean + w * 64 + row.ahead);
        hwy::Prefetch(row.limit + w * 64 + row.ahead);
        std::uint64_t word = 0;
        for (int i = 0; i < 64; i += lanes) {
            const int x = w * 64 + i;
            const auto frame = hn::LoadU(bytes, row.frame + x);
            const auto mean = hn::LoadU(bytes, row.mean + x);
            const auto limit = hn::LoadU(bytes, row.limit + x);
            const auto about = hn::SaturatedSub(hn::SaturatedAdd(mean, up), down);
            const auto perhaps = exceeds(distance(frame, about), hn::SaturatedSub(limit, slack));
            if (HWY_LIKELY(hn::AllFalse(bytes, perhaps))) continue;
            word |= store_bits(exceeds(distance(frame, predicted(mean, row.gain[w])), limit)) << i;
        }
        words[w] = word;
    }
}

void ShadowRowBits(const simd::ShadowRow& shadow_row, int first, int last, const std::uint64_t* foreground, std::uint64_t* shadow) {
    const BackgroundRow& row = shadow_row.row;
    const int lanes = static_cast<int>(hn::Lanes(bytes));
    const auto darkest = hn::Set(shorts, shadow_row.darkest);
    for (int w = first; w < last; ++w) {
        shadow[w] = 0;
        if (!foreground[w]) continue;
        if (w == 0 || w == row.words - 1) {
            scalar::shadow_row(shadow_row, w, w + 1, foreground, shadow);  // reads two pixels beyond the word
            continue;
        }
        for (int i = 0; i < 64; i += lanes) {
            const int x = w * 64 + i;
            const auto frame = hn::LoadU(bytes, row.frame + x);
            const auto expected = predicted(hn::LoadU(bytes, row.mean + x), row.gain[w]);
            const auto limit = hn::LoadU(bytes, row.limit + x);
            // expected * 256 * darkest / 2^24, in two steps of 16 bit
            const auto least = interleave(hn::ShiftRight<8>(hn::MulHigh(hn::ShiftLeft<8>(even_bytes(expected)), darkest)),
                                          hn::ShiftRight<8>(hn::MulHigh(hn::ShiftLeft<8>(odd_bytes(expected)), darkest)));
            const auto darker = hn::AndNot(exceeds(least, frame), exceeds(expected, frame));
            const auto step_x = distance(hn::LoadU(bytes, row.frame + x + 2), hn::LoadU(bytes, row.frame + x - 2));
            const auto known_x = distance(hn::LoadU(bytes, row.mean + x + 2), hn::LoadU(bytes, row.mean + x - 2));
            const auto step_y = distance(hn::LoadU(bytes, shadow_row.frame_below + x), hn::LoadU(bytes, shadow_row.frame_above + x));
            const auto known_y = distance(hn::LoadU(bytes, shadow_row.mean_below + x), hn::LoadU(bytes, shadow_row.mean_above + x));
            const auto structured = hn::Or(exceeds(step_x, hn::SaturatedAdd(known_x, limit)), exceeds(step_y, hn::SaturatedAdd(known_y, limit)));
            shadow[w] |= store_bits(hn::AndNot(structured, darker)) << i;
        }
        shadow[w] &= foreground[w];
    }
}

void BlockSums(const BlockRows& rows, PairSum* sums) {
    const int lanes = static_cast<int>(hn::Lanes(bytes));
    const hn::Repartition<std::uint64_t, Bytes> longs;
    for (int w = 0; w < rows.words; ++w) {
        auto frame = hn::Zero(longs);
        auto background = hn::Zero(longs);
        for (int r = 0; r < rows.count; ++r) {
            for (int i = 0; i < 64; i += lanes) {
                frame = hn::Add(frame, hn::SumsOf8(hn::LoadU(bytes, rows.frame[r] + w * 64 + i)));
                background = hn::Add(background, hn::SumsOf8(hn::LoadU(bytes, rows.mean[r] + w * 64 + i)));
            }
        }
        sums[w].frame = static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(longs, frame)));
        sums[w].background = static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(longs, background)));
    }
}

HWY_INLINE ShortVector towards(ShortVector from, ShortVector to, int shift) {
    const auto up = hn::ShiftRightSame(hn::SaturatedSub(to, from), shift);
    const auto down = hn::ShiftRightSame(hn::SaturatedSub(from, to), shift);
    return hn::Sub(hn::Add(from, up), down);
}

void RefreshRowBits(const RefreshRow& row) {
    const int lanes = static_cast<int>(hn::Lanes(shorts));
    const hn::Rebind<std::uint8_t, Shorts> narrow;
    const auto largest = hn::Set(shorts, 16 << 8);
    for (int w = 0; w < row.words; ++w) {
        if (row.keep[w] == ~0ULL) continue;
        const auto inverse_gain = hn::Set(shorts, row.inverse_gain[w]);
        for (int i = 0; i < 64; i += lanes) {
            const int x = w * 64 + i;
            alignas(16) std::uint8_t bits[16] = {};
            const std::uint64_t word = row.keep[w] >> i;
            std::memcpy(bits, &word, 8);
            const auto keep = hn::LoadMaskBits(shorts, bits);

            const auto frame = hn::ShiftLeft<8>(hn::PromoteTo(shorts, hn::LoadU(narrow, row.frame + x)));
            const auto half = hn::MulHigh(frame, inverse_gain);
            const auto light = hn::SaturatedAdd(half, half);
            const auto mean = hn::LoadU(shorts, row.mean_fine + x);
            const auto deviation = hn::LoadU(shorts, row.deviation + x);
            const auto usual = hn::Min(distance(light, mean), largest);
            const auto new_mean = hn::IfThenElse(keep, mean, towards(mean, light, row.mean_shift));
            const auto new_deviation = hn::IfThenElse(keep, deviation, towards(deviation, usual, row.noise_shift));
            hn::StoreU(new_mean, shorts, row.mean_fine + x);
            hn::StoreU(new_deviation, shorts, row.deviation + x);

            const auto rounded = hn::ShiftRight<8>(hn::SaturatedAdd(new_mean, hn::Set(shorts, 128)));
            const auto limit =
                hn::Add(hn::Add(hn::Set(shorts, row.limit_floor), hn::ShiftRight<6>(rounded)), hn::MulHigh(new_deviation, hn::Set(shorts, row.limit_factor)));
            const auto old_limit = hn::PromoteTo(shorts, hn::LoadU(narrow, row.limit + x));
            const auto kept_limit = hn::IfThenElse(keep, old_limit, hn::Min(limit, hn::Set(shorts, 255)));
            const auto old_mean = hn::PromoteTo(shorts, hn::LoadU(narrow, row.mean + x));
            const hn::RebindToSigned<Shorts> signed_shorts;
            hn::StoreU(hn::DemoteTo(narrow, hn::BitCast(signed_shorts, hn::IfThenElse(keep, old_mean, rounded))), narrow, row.mean + x);
            hn::StoreU(hn::DemoteTo(narrow, hn::BitCast(signed_shorts, kept_limit)), narrow, row.limit + x);
        }
    }
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace roomfix
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace roomfix::simd {

HWY_EXPORT(ClassifyRow);
HWY_EXPORT(ShadowRowBits);
HWY_EXPORT(BlockSums);
HWY_EXPORT(RefreshRowBits);

void classify_row(const BackgroundRow& row, std::uint64_t* words) { HWY_DYNAMIC_DISPATCH(ClassifyRow)(row, words); }
void shadow_row(const ShadowRow& row, int first, int last, const std::uint64_t* foreground, std::uint64_t* shadow) {
    HWY_DYNAMIC_DISPATCH(ShadowRowBits)(row, first, last, foreground, shadow);
}
void block_sums(const BlockRows& rows, PairSum* sums) { HWY_DYNAMIC_DISPATCH(BlockSums)(rows, sums); }
void refresh_row(const RefreshRow& row) { HWY_DYNAMIC_DISPATCH(RefreshRowBits)(row); }

}  // namespace roomfix::simd
#endif
