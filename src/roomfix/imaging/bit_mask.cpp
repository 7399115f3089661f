#include "roomfix/imaging/bit_mask.hpp"

#include <algorithm>

namespace roomfix {
namespace {

/// Bits begin..end-1 of a word, 0 <= begin < end <= 64.
std::uint64_t bit_range(int begin, int end) { return (~0ULL << begin) & (~0ULL >> (64 - end)); }

/// Calls visit(word, bits) for the words that the run begin <= x < end touches.
template <class Visit>
void for_words(int begin, int end, Visit visit) {
    for (int word = begin >> 6; word << 6 < end; ++word) {
        visit(word, bit_range(std::max(begin - (word << 6), 0), std::min(end - (word << 6), 64)));
    }
}

/// Combines each pixel of rows first..last-1 with its eight neighbours by `combine` (and / or); `outside` stands for words beyond the image.
template <class Combine>
void neighbourhood(const BitMask& mask, BitMask& result, std::uint64_t outside, int first, int last, Combine combine) {
    if (result.width() != mask.width() || result.height() != mask.height()) result.resize(mask.width(), mask.height());
    const int words = mask.words();
    const bool grows = outside == 0;
    for (int y = std::max(first, 0); y < std::min(last, mask.height()); ++y) {
        // Where can the result differ from zero? Clear what the last use left there.
        WordSpan& target = result.span(y);
        const bool alone = mask.span(y).empty() && (!grows || ((y == 0 || mask.span(y - 1).empty()) && (y + 1 == mask.height() || mask.span(y + 1).empty())));
        if (alone && target.empty()) continue;
        std::fill(result.row(y) + target.first, result.row(y) + std::max(target.first, target.last), 0);
        WordSpan reach = mask.span(y);
        if (grows) {
            for (int dy = -1; dy <= 1; dy += 2) {
                if (y + dy < 0 || y + dy >= mask.height() || mask.span(y + dy).empty()) continue;
                const WordSpan& other = mask.span(y + dy);
                reach = reach.empty() ? other : WordSpan{std::min(reach.first, other.first), std::max(reach.last, other.last)};
            }
            if (!reach.empty()) reach = {std::max(reach.first - 1, 0), std::min(reach.last + 1, words)};
        }
        target = reach.empty() ? WordSpan{0, 0} : reach;
        if (reach.empty()) continue;

        // A row in place of one beyond the image changes nothing.
        const std::uint64_t* here = mask.row(y);
        const std::uint64_t* above = y > 0 ? mask.row(y - 1) : here;
        const std::uint64_t* below = y + 1 < mask.height() ? mask.row(y + 1) : here;
        const auto column = [&](int w) { return combine(combine(here[w], above[w]), below[w]); };
        const auto border_column = [&](int w) -> std::uint64_t {
            if (w < 0 || w >= words) return outside;
            return w == words - 1 ? column(w) | (outside & ~mask.tail()) : column(w);
        };
        std::uint64_t* to = result.row(y);
        std::uint64_t left = border_column(reach.first - 1);
        std::uint64_t middle = border_column(reach.first);
        const auto step = [&](int w, std::uint64_t right) {
            to[w] = combine(combine(middle, (middle << 1) | (left >> 63)), (middle >> 1) | (right << 63));
            left = middle;
            middle = right;
        };
        const int inner = std::min(reach.last, words - 2);  // words whose right neighbour is not the last one
        int w = reach.first;
        for (; w < inner; ++w) step(w, column(w + 1));
        for (; w < reach.last; ++w) step(w, border_column(w + 1));
        if (reach.last == words) to[words - 1] &= mask.tail();
    }
}

}  // namespace

void BitMask::resize(int width, int height) {
    width_ = width;
    height_ = height;
    words_ = (width + 63) / 64;
    bits_.assign(static_cast<std::size_t>(words_) * static_cast<std::size_t>(height), 0);
    spans_.assign(static_cast<std::size_t>(height), WordSpan{});
}

void BitMask::clear() {
    for (int y = 0; y < height_; ++y) {
        if (!span(y).empty()) std::fill(row(y) + span(y).first, row(y) + span(y).last, 0);
        span(y) = {};
    }
}

void BitMask::set(int x, int y) {
    row(y)[x >> 6] |= 1ULL << (x & 63);
    WordSpan& s = span(y);
    const int word = x >> 6;
    s = s.empty() ? WordSpan{word, word + 1} : WordSpan{std::min(s.first, word), std::max(s.last, word + 1)};
}

void BitMask::set_run(int y, int begin, int end) {
    begin = std::max(begin, 0);
    end = std::min(end, width_);
    if (y < 0 || y >= height_ || begin >= end) return;
    set(begin, y);
    set(end - 1, y);
    std::uint64_t* words = row(y);
    for_words(begin, end, [&](int word, std::uint64_t bits) { words[word] |= bits; });
}

void BitMask::clear_run(int y, int begin, int end) {
    begin = std::max(begin, 0);
    end = std::min(end, width_);
    if (y < 0 || y >= height_ || begin >= end) return;
    std::uint64_t* words = row(y);
    for_words(begin, end, [&](int word, std::uint64_t bits) { words[word] &= ~bits; });
}

int BitMask::count_run(int y, int begin, int end) const {
    if (y < 0 || y >= height_) return 0;
    const WordSpan& s = span(y);
    begin = std::max(begin, s.first << 6);
    end = std::min({end, s.last << 6, width_});
    if (begin >= end) return 0;
    int total = 0;
    const std::uint64_t* words = row(y);
    for_words(begin, end, [&](int word, std::uint64_t bits) { total += std::popcount(words[word] & bits); });
    return total;
}

std::int64_t BitMask::count() const {
    std::int64_t total = 0;
    for (int y = 0; y < height_; ++y) {
        for (int w = span(y).first; w < span(y).last; ++w) total += std::popcount(row(y)[w]);
    }
    return total;
}

void erode(const BitMask& mask, BitMask& result) {
    neighbourhood(mask, result, ~0ULL, 0, mask.height(), [](std::uint64_t a, std::uint64_t b) { return a & b; });
}

void dilate(const BitMask& mask, BitMask& result) { dilate_rows(mask, result, 0, mask.height()); }

void dilate_rows(const BitMask& mask, BitMask& result, int first, int last) {
    neighbourhood(mask, result, 0, first, last, [](std::uint64_t a, std::uint64_t b) { return a | b; });
}

void open(BitMask& mask, BitMask& scratch) {
    erode(mask, scratch);
    dilate(scratch, mask);
}

void close(BitMask& mask, BitMask& scratch) {
    dilate(mask, scratch);
    erode(scratch, mask);
}

}  // namespace roomfix
