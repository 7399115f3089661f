#include "roomfix/imaging/background_model.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>

#include "roomfix/base/column_sort.hpp"
#include "roomfix/imaging/background_rows.hpp"

namespace roomfix {
namespace {

constexpr double sigma_per_deviation = 1.2533;  // sqrt(pi / 2), for normal noise

std::uint16_t limit_factor(const BackgroundSettings& settings) {
    return static_cast<std::uint16_t>(std::lround(settings.limit_sigmas * sigma_per_deviation * 256));
}

/// A row that may be read up to the next multiple of 64 pixels: the frame's own if it is that wide, otherwise a copy.
class PaddedRow {
public:
    PaddedRow(const LumaView& frame, int words) : frame_(frame), needed_(words * 64) {
        if (frame.stride < needed_) copy_.resize(static_cast<std::size_t>(needed_));
    }
    const std::uint8_t* operator()(int y) {
        if (copy_.empty()) return frame_.row(y);
        std::memcpy(copy_.data(), frame_.row(y), static_cast<std::size_t>(frame_.width));
        return copy_.data();
    }

private:
    LumaView frame_;
    int needed_;
    std::vector<std::uint8_t> copy_;
};

/// The part of a row that holds set bits.
WordSpan used_words(const std::uint64_t* row, int words) {
    WordSpan span{0, words};
    while (span.first < span.last && !row[span.first]) ++span.first;
    while (span.last > span.first && !row[span.last - 1]) --span.last;
    return span;
}

/// Marks the words of a row that hold a part of three set bits side by side; beyond the image all bits count as set.
void mark_thick(const std::uint64_t* row, WordSpan span, int width, std::span<std::uint64_t> marks) {
    std::fill(marks.begin(), marks.end(), 0);
    const auto mark = [&](int word) { marks[static_cast<std::size_t>(word >> 6)] |= 1ULL << (word & 63); };
    const int last = (width - 1) >> 6;
    for (int w = span.first; w < span.last; ++w) {
        const std::uint64_t beyond = w == last && width % 64 ? ~0ULL << (width % 64) : 0;
        const std::uint64_t word = row[w] | beyond;
        const std::uint64_t next = w == last ? ~0ULL : row[w + 1];
        if (w == 0 && (word & 3) == 3) mark(0);
        const std::uint64_t starts = word & ((word >> 1) | (next << 63)) & ((word >> 2) | (next << 62));
        if (!starts) continue;
        mark(w);
        if (starts >> 62 && w < last) mark(w + 1);
    }
}

/// Calls visit(first, last) for each stretch of words first..last-1 that one of the two sets of marks holds.
template <class Visit>
void for_marked(const std::uint64_t* a, const std::uint64_t* b, int words, Visit visit) {
    for (int w = 0; w < words;) {
        const std::uint64_t group = (a[w >> 6] | b[w >> 6]) >> (w & 63);
        if (!group) {
            w = (w & ~63) + 64;
            continue;
        }
        const int first = w + std::countr_zero(group);
        int last = first;
        while (last < words && ((a[last >> 6] | b[last >> 6]) >> (last & 63)) & 1U) ++last;
        visit(first, last);
        w = last;
    }
}

}  // namespace

BackgroundModel::BackgroundModel(int width, int height, const std::vector<float>& mean, const std::vector<float>& noise, const BackgroundSettings& settings)
    : settings_(settings), mean_(width, height), limit_(width, height) {
    const auto stride = static_cast<std::size_t>(mean_.view().stride);
    mean_fine_.assign(stride * static_cast<std::size_t>(height), 0);
    deviation_.assign(mean_fine_.size(), 0);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto from = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
            const auto to = static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x);
            mean_fine_[to] = static_cast<std::uint16_t>(std::lround(std::clamp(mean[from], 0.0f, 255.0f) * 256));
            deviation_[to] = static_cast<std::uint16_t>(std::lround(static_cast<double>(std::clamp(noise[from], 0.2f, 60.0f)) / sigma_per_deviation * 256));
            mean_.row(y)[x] = static_cast<std::uint8_t>(std::min(mean_fine_[to] + 128, 65535) >> 8);
            limit_.row(y)[x] = static_cast<std::uint8_t>(
                std::min<int>(settings.limit_floor + ((deviation_[to] * limit_factor(settings)) >> 16) + (mean_.row(y)[x] >> 6), 255));
        }
    }
}

/// Words first..first+words-1 of a row, for the kernels; `frame` is the frame's row y.
BackgroundRow BackgroundModel::row_at(const std::uint8_t* frame, int y, int first, int words, const Foreground& foreground) const {
    const std::ptrdiff_t x = std::ptrdiff_t{first} * block_width;
    const std::uint16_t* gain = foreground.gain.data() + (y / block_height) * blocks_x() + first;
    return {frame + x, mean_.row(y) + x, limit_.row(y) + x, gain, words};
}

/// The light of each block against the background: measured on one of its rows, the median over the frame for all that is
/// covered by something, smoothed over the neighbours.
void BackgroundModel::estimate_gain(LumaView frame, Foreground& result) const {
    const int across = blocks_x();
    const int down = blocks_y();
    const auto count = static_cast<std::size_t>(across) * static_cast<std::size_t>(down);
    result.ratios.resize(count);
    result.gain.resize(count);
    std::array<PairSum, 1024> sums;
    PaddedRow padded(frame, across);
    for (int by = 0; by < down; ++by) {
        const int top = by * block_height;
        const int y = std::min((top + block_height / 2) / 3 * 3 + 1, height() - 1);  // a row that classify_solid() reads as well
        const std::uint8_t* seen = padded(y);
        for (int first = 0; first < across; first += 1024) {
            const int words = std::min(across - first, 1024);
            simd::block_sums({{seen + first * 64}, {mean_.row(y) + first * 64}, 1, words}, sums.data());
            for (int i = 0; i < words; ++i) {
                const PairSum& s = sums[static_cast<std::size_t>(i)];
                result.ratios[static_cast<std::size_t>(by * across + first + i)] =
                    s.background > 0 ? static_cast<float>(s.frame) / static_cast<float>(s.background) : -1.0f;
            }
        }
    }
    result.sorted.clear();
    for (const float ratio : result.ratios) {
        if (ratio >= 0) result.sorted.push_back(ratio);
    }
    if (result.sorted.empty()) result.sorted.push_back(1.0f);
    const auto middle = result.sorted.begin() + static_cast<std::ptrdiff_t>(result.sorted.size() / 2);
    std::nth_element(result.sorted.begin(), middle, result.sorted.end());
    const float global = std::clamp(*middle, 0.1f, 10.0f);
    result.global_gain = global;

    // Mean over the block and its eight neighbours, of those whose light goes with the rest: sums across, then down.
    const float widest = static_cast<float>(settings_.largest_local_gain) * global;
    const auto line = static_cast<std::size_t>(across);
    result.across.assign(2 * (count + 2 * line), 0.0f);
    float* sum = result.across.data() + line;  // a line of nothing above and below
    float* used = sum + count + 2 * line;
    int covered = 0;
    for (std::size_t row = 0; row < count; row += line) {
        for (std::size_t x = 0; x < line; ++x) {
            const float ratio = result.ratios[row + x];
            if (std::abs(ratio - global) > widest) {
                ++covered;
                continue;
            }
            for (std::size_t to = x > 0 ? x - 1 : 0; to < std::min(x + 2, line); ++to) {
                sum[row + to] += ratio;
                used[row + to] += 1;
            }
        }
    }
    const auto around = [line](const float* at) { return *(at - line) + *at + *(at + line); };
    for (std::size_t block = 0; block < count; ++block) {
        const float n = around(used + block);
        const float gain = n >= 3 ? around(sum + block) / n : global;
        result.gain[block] = static_cast<std::uint16_t>(std::clamp(gain, 0.05f, 60.0f) * 1024 + 0.5f);
    }
    result.covered = static_cast<double>(covered) / static_cast<double>(count);
}

void BackgroundModel::prepare(LumaView frame, Foreground& result) const {
    if (result.mask.width() != width() || result.mask.height() != height()) {
        result.mask.resize(width(), height());
        result.shadow.resize(width(), height());
        result.scratch.resize(width(), height());
    }
    estimate_gain(frame, result);
}

void BackgroundModel::classify(LumaView frame, Foreground& result) const {
    prepare(frame, result);
    const int words = result.mask.words();
    PaddedRow padded(frame, words);
    for (int y = 0; y < height(); ++y) {
        std::uint64_t* row = result.mask.row(y);
        simd::classify_row(row_at(padded(y), y, 0, words, result), row);
        row[words - 1] &= result.mask.tail();
        result.mask.span(y) = used_words(row, words);
    }
    find_shadow(frame, result);
}

void BackgroundModel::classify_solid(LumaView frame, Foreground& result) const {
    prepare(frame, result);
    BitMask& mask = result.mask;
    const int words = mask.words();
    const std::size_t groups = static_cast<std::size_t>(words + 63) / 64;
    result.thick.assign(2 * groups, 0);
    std::uint64_t* above = result.thick.data();
    std::uint64_t* below = above + groups;
    PaddedRow padded(frame, words);
    // Rows 1, 4, 7, ... are looked at whole, and the last one: the image's border counts as foreground for opening.
    for (int done = 0; done < height();) {
        const int whole = std::min(done + (done == 0 ? 1 : 2), height() - 1);
        std::uint64_t* row = mask.row(whole);
        BackgroundRow whole_row = row_at(padded(whole), whole, 0, words, result);
        whole_row.ahead = 3 * mean_.view().stride;
        simd::classify_row(whole_row, row);
        row[words - 1] &= mask.tail();
        mask.span(whole) = used_words(row, words);
        mark_thick(row, mask.span(whole), width(), {below, groups});
        for (int y = done; y < whole; ++y) {
            std::uint64_t* between = mask.row(y);
            WordSpan& span = mask.span(y);
            std::fill(between + span.first, between + std::max(span.first, span.last), 0);
            span = {};
            for_marked(above, below, words, [&](int first, int last) {
                simd::classify_row(row_at(padded(y), y, first, last - first, result), between + first);
                span = span.empty() ? WordSpan{first, last} : WordSpan{span.first, last};
            });
            between[words - 1] &= mask.tail();
        }
        done = whole + 1;
        std::swap(above, below);
    }
    open(mask, result.scratch);
    find_shadow(frame, result);
}

/// What of the foreground may be a shadow: darker, but not black, and no step that the background has not.
void BackgroundModel::find_shadow(LumaView frame, Foreground& result) const {
    const int words = result.mask.words();
    const auto darkest = static_cast<std::uint16_t>(std::lround(settings_.shadow_darkest * 65536));
    PaddedRow padded(frame, words);
    PaddedRow above(frame, words);
    PaddedRow below(frame, words);
    result.shadow.clear();
    for (int y = 0; y < height(); ++y) {
        const WordSpan span = result.mask.span(y);
        if (span.empty()) continue;
        const int up = std::max(y - 2, 0);
        const int down = std::min(y + 2, height() - 1);
        const simd::ShadowRow row{row_at(padded(y), y, 0, words, result), above(up), below(down), mean_.row(up), mean_.row(down), darkest};
        simd::shadow_row(row, span.first, span.last, result.mask.row(y), result.shadow.row(y));
        result.shadow.span(y) = span;
    }
}

void BackgroundModel::add_faint(LumaView frame, int left, int top, int right, int bottom, Foreground& result) const {
    // Sums over a window from running sums down the columns, then across.
    constexpr int rows = 5;
    left = std::max(left, 2);
    top = std::max(top, 2);
    right = std::min(right, width() - 3);
    bottom = std::min(bottom, height() - 3);
    if (left > right || top > bottom) return;
    const int across = right - left + 5;  // two more columns to each side
    result.sums.resize(static_cast<std::size_t>(across) * (rows + 2));
    const auto line = [&](int i) { return result.sums.data() + static_cast<std::ptrdiff_t>(i) * across; };
    int* wide = line(rows);        // down five rows
    int* narrow = line(rows + 1);  // down three
    const auto difference = [&](int y) {
        const std::uint16_t* gain = result.gain.data() + (y / block_height) * blocks_x();
        int* to = line(y % rows);
        for (int i = 0; i < across; ++i) {
            const int x = left - 2 + i;
            to[i] = frame.row(y)[x] - static_cast<int>((((mean_.row(y)[x] << 6) + 32) * gain[x / block_width]) >> 16);
        }
    };
    for (int y = top - 2; y < top + 2; ++y) difference(y);
    for (int y = top; y <= bottom; ++y) {
        difference(y + 2);
        for (int i = 0; i < across; ++i) {
            narrow[i] = line((y - 1) % rows)[i] + line(y % rows)[i] + line((y + 1) % rows)[i];
            wide[i] = narrow[i] + line((y - 2) % rows)[i] + line((y + 2) % rows)[i];
        }
        for (int i = 2; i + 2 < across; ++i) {
            const int x = left - 2 + i;
            const int large = wide[i - 2] + wide[i - 1] + wide[i] + wide[i + 1] + wide[i + 2];
            const int small = narrow[i - 1] + narrow[i] + narrow[i + 1];
            // Of the limit, the part that is noise shrinks with the root of the number of pixels; the rest does not.
            const int fixed = settings_.limit_floor + (mean_.row(y)[x] >> 6);
            const int noise = std::max(limit_.row(y)[x] - fixed, 0);
            if (std::abs(large) <= 25 * fixed + 5 * noise || std::abs(small) <= 9 * fixed + 3 * noise) continue;
            if (result.mask.at(x, y)) continue;
            result.mask.set(x, y);
            if (large < 0) result.shadow.set(x, y);
        }
    }
}

void BackgroundModel::refresh(LumaView frame, const Foreground& foreground, const BitMask& keep) {
    const int words = keep.words();
    const int rows = refresh_rows();
    PaddedRow padded(frame, words);
    std::array<std::uint16_t, 1024> inverse_gain;
    for (int i = 0; i < rows; ++i) {
        const int y = next_row_;
        const auto stride = static_cast<std::size_t>(mean_.view().stride) * static_cast<std::size_t>(y);
        for (int first = 0; first < words; first += 1024) {
            const int part = std::min(words - first, 1024);
            const std::uint16_t* gain = foreground.gain.data() + (y / block_height) * blocks_x() + first;
            for (int w = 0; w < part; ++w) {
                inverse_gain[static_cast<std::size_t>(w)] = static_cast<std::uint16_t>(std::min(32768 * 1024 / gain[w], 65535));
            }
            const auto start = stride + static_cast<std::size_t>(first) * 64;
            simd::refresh_row({padded(y) + first * 64, keep.row(y) + first, inverse_gain.data(), mean_fine_.data() + start, deviation_.data() + start,
                               mean_.row(y) + first * 64, limit_.row(y) + first * 64, part, settings_.mean_shift, settings_.noise_shift,
                               limit_factor(settings_), static_cast<std::uint8_t>(settings_.limit_floor)});
        }
        if (++next_row_ == height()) {
            next_row_ = 0;
            ++passes_;
        }
    }
}

bool BackgroundLearner::add(LumaView frame) {
    if (!frames_.empty() && (frame.width != frames_[0].width() || frame.height != frames_[0].height())) return false;
    if (offered_++ % step_ != 0) return true;
    if (frames() == capacity_) {
        for (std::size_t i = 0; 2 * i < frames_.size(); ++i) std::swap(frames_[i], frames_[2 * i]);
        frames_.resize((frames_.size() + 1) / 2);
        step_ *= 2;
        if ((offered_ - 1) % step_ != 0) return true;
    }
    frames_.push_back(copy_of(frame));
    return true;
}

BackgroundModel BackgroundLearner::learn(const BackgroundSettings& settings) const {
    if (frames_.empty()) return {};
    const int width = frames_[0].width();
    const int height = frames_[0].height();
    const std::size_t count = frames_.size();

    // The whole frame's gain against the first, from the median of the rows' ratios.
    std::vector<float> inverse_gain(count, 1.0f);
    for (std::size_t f = 1; f < count; ++f) {
        std::vector<float> ratios;
        for (int y = 0; y < height; y += 4) {
            for (int x = 0; x + 32 <= width; x += 32) {
                float mine = 0;
                float first = 0;
                for (int i = 0; i < 32; ++i) {
                    mine += frames_[f].row(y)[x + i];
                    first += frames_[0].row(y)[x + i];
                }
                if (mine > 0) ratios.push_back(first / mine);
            }
        }
        if (ratios.empty()) continue;
        const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
        std::nth_element(ratios.begin(), middle, ratios.end());
        inverse_gain[f] = *middle;
    }

    std::vector<float> mean(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    std::vector<float> noise(mean.size(), 4.0f);
    std::vector<ColumnRow> values(count), sorted(count);
    for (int y = 0; y < height; ++y) {
        for (int first = 0; first < width; first += static_cast<int>(columns_together)) {
            const auto columns = std::min(columns_together, static_cast<std::size_t>(width - first));
            const auto at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(first);
            for (std::size_t f = 0; f < count; ++f) {
                const std::uint8_t* row = frames_[f].row(y) + first;
                for (std::size_t x = 0; x < columns; ++x) values[f][x] = row[x] * inverse_gain[f];
            }
            sorted = values;
            sort_columns(sorted);
            const ColumnRow median = sorted[count / 2];
            for (std::size_t f = 0; f < count; ++f) {
                for (std::size_t x = 0; x < columns_together; ++x) sorted[f][x] = std::abs(values[f][x] - median[x]);
            }
            sort_columns(sorted);
            ColumnRow sum{}, squares{}, used{};
            for (const ColumnRow& row : values) {
                for (std::size_t x = 0; x < columns_together; ++x) {
                    const bool kept = std::abs(row[x] - median[x]) <= 4 * std::max(sorted[count / 2][x], 1.0f);
                    const float v = kept ? row[x] : 0.0f;
                    sum[x] += v;
                    squares[x] += v * v;
                    used[x] += kept ? 1.0f : 0.0f;
                }
            }
            for (std::size_t x = 0; x < columns; ++x) {
                mean[at + x] = sum[x] / used[x];
                if (used[x] < 2) continue;
                // With few frames the spread is itself uncertain: mix in one made-up frame with a noise of 4 grey levels.
                const float spread = std::max(squares[x] - used[x] * mean[at + x] * mean[at + x], 0.0f);
                noise[at + x] = std::sqrt((spread + 16.0f) / used[x]);
            }
        }
    }
    return {width, height, mean, noise, settings};
}

}  // namespace roomfix
