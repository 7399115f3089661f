// Tells what is not the background from the background in another light, by colour.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/imaging/evidence.hpp"

namespace roomfix {

struct EvidenceSettings {
    float dark = 6;                 // grey levels added before the logarithm: read noise and black level of common cameras
    float least_noise = 0.04f;      // of a log colour: compression and rounding at middle grey
    float shift = 0.5f;             // px that the picture may have moved against the background (wind, a touched mount): noise where it has edges
    float share_lit = 0.08f;        // of pixels lie in a shadow or in a patch of light that the background has not
    float share_other = 0.10f;      // of pixels show something else
    float darkest = -1.3f;          // log of what a shadow leaves of the light
    float brightest = 0.8f;         // log of what the sun adds to it
    float light_spread = 0.2f;      // softness of these two ends
    float light_colour = 0.07f;     // by which shadow and sun shift a log colour against their mean: sky and lamps differ
    float other_range = 2;          // over which log colours of other things are spread evenly, each channel
    float even_things = 0.5f;       // part of other things' pixels that lie in surfaces as even as a shadow
    float perhaps = 0.25f;          // part of what may as well be a shadow that counts as something else until a robot explains it
    float structure_weight = 0.2f;  // of a neighbouring pixel's word on whether the background's structure goes on: their noise is not independent
    float pixel_structure = 4;      // nats: the most that one pixel tells of it ...
    float most_structure = 6;       // ... and a neighbourhood
    float static_limit = 0.35f;     // log light by which a pixel may be off its block's at first, to count as unchanged
    float static_close = 0.15f;     // the same once the block's light is known roughly
};

/// Log colours of the empty scene, and how much they vary. What only changes the light, all over or smoothly from place to place and channel
/// by channel (exposure, white balance, lamps), is solved for within each frame; shadows and patches of light keep the background's
/// structure and nearly its colour. Robots are what does neither.
class ColourBackground {
public:
    ColourBackground() = default;
    explicit ColourBackground(const EvidenceSettings& settings) : settings_(settings) {}

    bool empty() const { return mean_.empty(); }
    int width() const { return width_; }
    int height() const { return height_; }
    int channels() const { return channels_; }
    int scale() const { return scale_; }

    /// Per-pixel median of the frames in one light; robots may stand in some of them, as long as each place is free in most. All frames must
    /// be of one size; with a grey one among them, all count as grey.
    void learn(std::vector<ColourImage> frames);
    /// Of a frame of the background's size; a grey frame is compared in grey, and so is any with a grey background. False if the size is another.
    bool compare(const ColourImage& frame, Evidence& evidence);
    /// The empty scene as a frame of the camera would show it; empty without one.
    ColourImage picture() const;
    /// After compare(): what surely is background moves it by `part` of the difference, one in four rows each time, and so many times farther.
    void refresh(const Evidence& evidence, float part);

private:
    std::size_t pixels() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_); }
    void set_grey();
    void to_log(const ColourImage& frame, std::vector<float>& log) const;
    void keep_noise();
    void couple_blocks(int across, int down, const std::array<float, 3>& all);
    void solve_light(std::vector<float>& difference);
    void learn_noise(const std::vector<std::vector<float>>& frames);
    void add_shift_noise();
    void subtract_light(int across, int down, std::vector<float>& difference);
    void find_changed();
    float unevenness(const std::vector<float>& levels, const std::vector<float>& means, int x, int y) const;
    float roughness(std::size_t i) const;
    void compare_structure();
    void judge_pixels(Evidence& evidence);
    struct Batch;
    void judge(Batch& batch) const;
    void keep_colours(Evidence& evidence) const;

    EvidenceSettings settings_;
    int width_ = 0;
    int height_ = 0;
    int channels_ = 3;
    int scale_ = 1;
    std::vector<float> mean_;   // log colours
    std::vector<float> noise_;  // standard deviation of a channel's log colour, per pixel
    std::vector<float> inverse_noise_;
    std::vector<float> log_noise_;
    std::size_t turn_ = 0;  // of the rows that refresh() looks at

    // Working memory, kept between frames.
    ColourImage grey_;
    std::vector<float> difference_;        // log colours of the frame in the background's light, less the background's
    std::vector<float> level_;             // mean of the channels' differences
    std::vector<float> around_;            // the same over a window
    std::vector<float> seen_;              // mean of the channels' log colours in the background's light
    std::vector<float> around_seen_;       // the same over a window
    std::vector<float> squares_;           // of the differences over their noise, all channels
    std::vector<float> uneven_;            // how far the difference is off its surroundings'
    std::vector<float> even_;              // the same of the frame itself
    std::vector<float> structure_;         // nats for the background's structure, against a thing as even as a shadow
    std::vector<float> around_structure_;  // the same over a window
    std::vector<float> column_;
    std::vector<float> sorted_;
    std::vector<float> blocks_;
    std::vector<float> weights_;
    std::vector<float> smooth_;
    std::vector<float> along_;
    std::vector<float> samples_;
    std::vector<std::size_t> first_sample_;
    std::vector<int> changed_;  // pixels that are not plainly the background
};

/// Keeps some of the frames that it is shown, evenly spread, for a background to be learned from.
class ColourFrames {
public:
    explicit ColourFrames(std::size_t most = 24) : most_(most) {}

    void add(const ColourImage& frame);
    const std::vector<ColourImage>& frames() const { return frames_; }

private:
    std::size_t most_;
    std::size_t offered_ = 0;
    std::size_t step_ = 1;
    std::vector<ColourImage> frames_;
};

}  // namespace roomfix
