// A binary image, 64 pixels to a word.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace roomfix {

/// The words of a row that may hold set bits: [first, last). Empty where first >= last.
struct WordSpan {
    int first = 0;
    int last = 0;
    bool empty() const { return first >= last; }
};

/// Bit x % 64 of word x / 64 of row y is pixel (x, y); bits beyond the width are 0. Every set bit lies in its row's span,
/// so that everything here passes over the empty parts of the image.
class BitMask {
public:
    BitMask() = default;
    BitMask(int width, int height) { resize(width, height); }

    /// Sets the size and clears all bits.
    void resize(int width, int height);
    void clear();

    int width() const { return width_; }
    int height() const { return height_; }
    int words() const { return words_; }
    std::uint64_t* row(int y) { return bits_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(words_); }
    const std::uint64_t* row(int y) const { return bits_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(words_); }
    WordSpan& span(int y) { return spans_[static_cast<std::size_t>(y)]; }
    const WordSpan& span(int y) const { return spans_[static_cast<std::size_t>(y)]; }

    bool at(int x, int y) const { return (row(y)[x >> 6] >> (x & 63)) & 1U; }
    void set(int x, int y);
    /// Sets the pixels begin <= x < end of a row; the bounds may lie outside the image.
    void set_run(int y, int begin, int end);
    /// Clears the pixels begin <= x < end of a row.
    void clear_run(int y, int begin, int end);
    /// How many pixels of begin <= x < end are set in a row; the bounds may lie outside the image.
    int count_run(int y, int begin, int end) const;
    std::int64_t count() const;

    /// The bits of the last word of a row that are inside the image.
    std::uint64_t tail() const { return width_ % 64 ? (1ULL << (width_ % 64)) - 1 : ~0ULL; }

private:
    int width_ = 0;
    int height_ = 0;
    int words_ = 0;
    std::vector<std::uint64_t> bits_;
    std::vector<WordSpan> spans_;
};

/// Erosion and dilation by a 3 x 3 square, on whole words. Outside the image counts as set for erosion and as clear for
/// dilation, so that an object cut by the border is not eaten from there. `result` takes the size of `mask`; no allocation
/// when it has it already.
void erode(const BitMask& mask, BitMask& result);
void dilate(const BitMask& mask, BitMask& result);
/// Only rows first <= y < last of the result are made.
void dilate_rows(const BitMask& mask, BitMask& result, int first, int last);
/// Erosion then dilation: removes specks thinner than three pixels.
void open(BitMask& mask, BitMask& scratch);
/// Dilation then erosion: fills gaps thinner than three pixels.
void close(BitMask& mask, BitMask& scratch);

}  // namespace roomfix
