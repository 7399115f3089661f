// What a fixed camera sees when no robot is there, and what differs from it.
#pragma once

#include <cstdint>
#include <vector>

#include "roomfix/imaging/bit_mask.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct BackgroundSettings {
    double limit_sigmas = 5;           // a pixel is foreground if it is off by more than this many standard deviations ...
    int limit_floor = 3;               // ... plus this many grey levels
    double shadow_darkest = 0.5;       // a shadow leaves at least this part of the grey level
    double largest_local_gain = 0.10;  // a block's gain may differ from the whole frame's by this part, else it is covered
    int refresh_passes = 64;           // frames that one pass of the selective refresh over the image takes
    int mean_shift = 2;                // each pass moves the mean by 1/4 of the difference
    int noise_shift = 4;               // and the noise by 1/16
};

/// What differs from the background in one frame.
struct Foreground {
    BitMask mask;                      // differs by more than the noise
    BitMask shadow;                    // subset: darker, and no structure that the background has not: may be a shadow
    std::vector<std::uint16_t> gain;   // frame / background light per block, 1024 = 1
    std::vector<float> ratios;         // working memory: measured light ratio per block
    std::vector<float> sorted;         // working memory
    std::vector<float> across;         // working memory: ratios summed over neighbouring blocks
    std::vector<int> sums;             // working memory
    std::vector<std::uint64_t> thick;  // working memory: which words of a row hold three set bits side by side
    BitMask scratch;                   // working memory
    float global_gain = 1;             // median over the blocks
    double covered = 0;                // part of the blocks whose light does not go with the rest: 0..1
};

struct BackgroundRow;

/// Mean and noise of every pixel. Blocks of 64 x 32 pixels share one gain, so that slow light changes, flicker and
/// automatic exposure are not foreground.
class BackgroundModel {
public:
    static constexpr int block_width = 64;
    static constexpr int block_height = 32;

    BackgroundModel() = default;
    /// mean, noise: row-major, width * height; grey levels and their standard deviation.
    BackgroundModel(int width, int height, const std::vector<float>& mean, const std::vector<float>& noise, const BackgroundSettings& settings = {});

    bool empty() const { return mean_.empty(); }
    int width() const { return mean_.width(); }
    int height() const { return mean_.height(); }
    LumaView mean() const { return mean_.view(); }
    /// How far a pixel may be off the mean before it is foreground, grey levels.
    LumaView limit() const { return limit_.view(); }
    const BackgroundSettings& settings() const { return settings_; }

    /// Splits a frame of the model's size. No allocation when `result` was used for this size before.
    void classify(LumaView frame, Foreground& result) const;

    /// The same after opening the mask (bit_mask.hpp), for about a third of the memory traffic: every 3 x 3 square of
    /// foreground crosses one row in three with three bits side by side, so the rows between are looked at only there.
    void classify_solid(LumaView frame, Foreground& result) const;

    /// Adds what differs from the background too little for single pixels to tell: within the box (px, inclusive), means
    /// over 5 x 5 and over 3 x 3 pixels must both differ by more than their own noise. Many times slower than classify().
    void add_faint(LumaView frame, int left, int top, int right, int bottom, Foreground& result) const;

    /// Moves mean and noise of the next strip of rows towards the frame where `keep` is clear. Call once per frame.
    void refresh(LumaView frame, const Foreground& foreground, const BitMask& keep);
    /// The rows that the next refresh() looks at: refresh_rows() of them from refresh_first() on, going on at row 0.
    int refresh_first() const { return next_row_; }
    int refresh_rows() const { return (height() + settings_.refresh_passes - 1) / settings_.refresh_passes; }
    /// Counts completed passes of refresh() over the whole image.
    int passes() const { return passes_; }

    /// Gain of the block that holds a pixel.
    float gain_at(const Foreground& foreground, int x, int y) const {
        const int block = (y / block_height) * blocks_x() + x / block_width;
        return static_cast<float>(foreground.gain[static_cast<std::size_t>(block)]) * (1.0f / 1024);
    }

private:
    int blocks_x() const { return (width() + block_width - 1) / block_width; }
    int blocks_y() const { return (height() + block_height - 1) / block_height; }
    BackgroundRow row_at(const std::uint8_t* frame, int y, int first, int words, const Foreground& foreground) const;
    void prepare(LumaView frame, Foreground& result) const;
    void estimate_gain(LumaView frame, Foreground& result) const;
    void find_shadow(LumaView frame, Foreground& result) const;

    BackgroundSettings settings_;
    LumaImage mean_;  // rounded mean_fine_
    LumaImage limit_;
    std::vector<std::uint16_t> mean_fine_;  // 1/256 grey level; rows of mean_.stride
    std::vector<std::uint16_t> deviation_;  // mean absolute deviation, 1/256 grey level
    int next_row_ = 0;
    int passes_ = 0;
};

/// Learns a model from frames in which robots may pass, as long as each pixel is free more than half of the time:
/// per-pixel median of gain-normalised frames, then mean and deviation of those near the median.
class BackgroundLearner {
public:
    /// Keeps at most `capacity` frames; when full, every second one is dropped and only every second new one is taken.
    explicit BackgroundLearner(int capacity = 64) : capacity_(capacity) {}

    /// Frames of another size than the first are refused (false).
    bool add(LumaView frame);
    int frames() const { return static_cast<int>(frames_.size()); }
    /// Empty if no frame was added. A single frame gets a noise of 4 grey levels.
    BackgroundModel learn(const BackgroundSettings& settings = {}) const;

private:
    int capacity_;
    std::int64_t offered_ = 0;
    std::int64_t step_ = 1;
    std::vector<LumaImage> frames_;
};

}  // namespace roomfix
