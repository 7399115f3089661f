#include "roomfix/imaging/evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

constexpr int block = 48;            // px, edge of the squares that share a light
constexpr int light_window = 3;      // px to each side over which a shadow's light is even
constexpr int structure_window = 5;  // px to each side over which structure is compared
constexpr float window_pixels = (2 * structure_window + 1) * (2 * structure_window + 1);
constexpr std::size_t most_frames = 24;
constexpr float log_two_pi = 1.8378771f;

int blocks_along(int length) { return (length + block - 1) / block; }

float median(std::vector<float>& values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Means over squares of 2 * window + 1 pixels, cut off at the picture's borders.
void box_mean(const std::vector<float>& from, int width, int height, int window, std::vector<float>& column, std::vector<float>& to) {
    to.resize(from.size());
    column.assign(static_cast<std::size_t>(width), 0.0f);
    const auto row = [&](int y) { return from.data() + static_cast<std::ptrdiff_t>(y) * width; };
    const auto add = [&](int y, float sign) {
        for (int x = 0; x < width; ++x) column[static_cast<std::size_t>(x)] += sign * row(y)[x];
    };
    for (int y = 0; y < std::min(window, height); ++y) add(y, 1);
    for (int y = 0; y < height; ++y) {
        if (y + window < height) add(y + window, 1);
        if (y - window - 1 >= 0) add(y - window - 1, -1);
        const int rows = std::min(y + window, height - 1) - std::max(y - window, 0) + 1;
        float sum = 0;
        for (int x = 0; x < std::min(window, width); ++x) sum += column[static_cast<std::size_t>(x)];
        for (int x = 0; x < width; ++x) {
            if (x + window < width) sum += column[static_cast<std::size_t>(x + window)];
            if (x - window - 1 >= 0) sum -= column[static_cast<std::size_t>(x - window - 1)];
            const int columns = std::min(x + window, width - 1) - std::max(x - window, 0) + 1;
            to[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = sum / static_cast<float>(rows * columns);
        }
    }
}

}  // namespace

void Evidence::count_perhaps() {
    if (perhaps_counts) return;
    for (std::size_t i = 0; i < perhaps.size(); ++i) pixels[i].other += perhaps[i];
    perhaps_counts = true;
}

int Evidence::explain_shadows(std::vector<int>& from) {
    constexpr float least = 0.05f;
    int first = width * height;
    while (!from.empty()) {
        const int i = from.back();
        from.pop_back();
        first = std::min(first, i);
        const int x = i % width;
        const auto visit = [&](int next) {
            float& shadow = perhaps[static_cast<std::size_t>(next)];
            if (shadow < least) return;
            if (perhaps_counts) pixels[static_cast<std::size_t>(next)].other -= shadow;
            shadow = 0;
            from.push_back(next);
        };
        if (x > 0) visit(i - 1);
        if (x + 1 < width) visit(i + 1);
        if (i >= width) visit(i - width);
        if (i + width < width * height) visit(i + width);
    }
    return first / std::max(width, 1);
}

void Evidence::sum_up(int first_row) {
    const auto line = static_cast<std::size_t>(width) + 1;
    row_sums.resize(line * static_cast<std::size_t>(height));
    box_sums.resize(line * (static_cast<std::size_t>(height) + 1));
    if (first_row == 0) std::fill(box_sums.begin(), box_sums.begin() + static_cast<std::ptrdiff_t>(line), Sums());
    for (auto y = static_cast<std::size_t>(first_row); y < static_cast<std::size_t>(height); ++y) {
        const Sums* from = pixels.data() + y * static_cast<std::size_t>(width);
        Sums* row = row_sums.data() + y * line;
        const Sums* above = box_sums.data() + y * line;
        Sums* below = box_sums.data() + (y + 1) * line;
        row[0] = below[0] = {};
        for (std::size_t x = 0; x + 1 < line; ++x) {
            row[x + 1] = {row[x].other + from[x].other, row[x].plain + from[x].plain};
            below[x + 1] = {above[x + 1].other + row[x + 1].other, above[x + 1].plain + row[x + 1].plain};
        }
    }
    const Sums all = box_sums.back();
    clutter = static_cast<double>(all.other) / std::max(1.0, static_cast<double>(all.other + all.plain));
}

void ColourBackground::set_grey() {
    if (channels_ == 1) return;
    const std::size_t count = pixels();
    for (std::size_t i = 0; i < count; ++i) mean_[i] = (mean_[3 * i] + mean_[3 * i + 1] + mean_[3 * i + 2]) / 3;
    mean_.resize(count);
    channels_ = 1;
}

void ColourBackground::to_log(const ColourImage& frame, std::vector<float>& log) const {
    std::array<float, 256> table;
    for (int i = 0; i < 256; ++i) table[static_cast<std::size_t>(i)] = std::log(static_cast<float>(i) + settings_.dark);
    log.resize(frame.values.size());
    for (std::size_t i = 0; i < log.size(); ++i) log[i] = table[frame.values[i]];
}

/// The light of each block from all around it: a Gaussian over blocks and a little of the whole picture's light.
void ColourBackground::couple_blocks(int across, int down, const std::array<float, 3>& all) {
    constexpr int reach = 2;        // blocks; the Gaussian's standard deviation is one
    constexpr float whole = 0.02f;  // weight of the whole picture's light
    const auto c = static_cast<std::size_t>(channels_);
    for (int by = 0; by < down; ++by) {
        for (int bx = 0; bx < across; ++bx) {
            const auto b = static_cast<std::size_t>(by * across + bx);
            float sum = whole;
            std::array<float, 3> light{};
            for (std::size_t k = 0; k < c; ++k) light[k] = whole * all[k];
            for (int ny = std::max(by - reach, 0); ny <= std::min(by + reach, down - 1); ++ny) {
                for (int nx = std::max(bx - reach, 0); nx <= std::min(bx + reach, across - 1); ++nx) {
                    const auto n = static_cast<std::size_t>(ny * across + nx);
                    const float w = weights_[n] * std::exp(-0.5f * static_cast<float>((nx - bx) * (nx - bx) + (ny - by) * (ny - by)));
                    sum += w;
                    for (std::size_t k = 0; k < c; ++k) light[k] += w * blocks_[n * c + k];
                }
            }
            for (std::size_t k = 0; k < c; ++k) smooth_[b * c + k] = light[k] / sum;
        }
    }
}

/// Takes the light out of the differences: one number per block and channel, from pixels that did not change otherwise, blocks that are
/// covered from their neighbours, bilinear between them.
void ColourBackground::solve_light(std::vector<float>& difference) {
    const int across = blocks_along(width_);
    const int down = blocks_along(height_);
    const auto c = static_cast<std::size_t>(channels_);
    const auto count = static_cast<std::size_t>(across * down);
    std::array<float, 3> all{};
    for (std::size_t k = 0; k < c; ++k) {
        sorted_.clear();
        for (std::size_t i = 0; i < pixels(); i += 17) sorted_.push_back(difference[i * c + k]);
        all[k] = median(sorted_);
    }
    smooth_.resize(count * c);
    for (std::size_t b = 0; b < count; ++b) {
        for (std::size_t k = 0; k < c; ++k) smooth_[b * c + k] = all[k];
    }
    blocks_.resize(count * c);
    weights_.resize(count);
    for (const float limit : {settings_.static_limit, settings_.static_close, settings_.static_close}) {
        for (int by = 0; by < down; ++by) {
            for (int bx = 0; bx < across; ++bx) {
                const auto b = static_cast<std::size_t>(by * across + bx);
                const int right = std::min((bx + 1) * block, width_);
                const int bottom = std::min((by + 1) * block, height_);
                float seen = 0;
                float still = 0;
                for (std::size_t k = 0; k < c; ++k) {
                    sorted_.clear();
                    for (int y = by * block; y < bottom; y += 3) {
                        for (int x = bx * block + (y / 3) % 3; x < right; x += 3) {
                            const float d = difference[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)) * c + k];
                            seen += 1;
                            if (std::abs(d - smooth_[b * c + k]) < limit) sorted_.push_back(d);
                        }
                    }
                    still += static_cast<float>(sorted_.size());
                    blocks_[b * c + k] = sorted_.size() > 16 ? median(sorted_) : smooth_[b * c + k];
                }
                weights_[b] = seen > 0 ? std::pow(still / seen, 2.0f) : 0;
            }
        }
        couple_blocks(across, down, all);
    }
    // Bilinear between the blocks' middles: the blocks' rows first.
    blocks_.resize(static_cast<std::size_t>(across) * c);
    const auto column = [&](int x) { return std::clamp((static_cast<float>(x) + 0.5f) / block - 0.5f, 0.0f, static_cast<float>(across - 1)); };
    for (int y = 0; y < height_; ++y) {
        const float v = std::clamp((static_cast<float>(y) + 0.5f) / block - 0.5f, 0.0f, static_cast<float>(down - 1));
        const int top = static_cast<int>(v);
        const int below = std::min(top + 1, down - 1);
        const float fy = v - static_cast<float>(top);
        for (std::size_t i = 0; i < blocks_.size(); ++i) {
            blocks_[i] = smooth_[static_cast<std::size_t>(top * across) * c + i] * (1 - fy) + smooth_[static_cast<std::size_t>(below * across) * c + i] * fy;
        }
        float* d = difference.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) * c;
        for (int x = 0; x < width_; ++x) {
            const float u = column(x);
            const int left = static_cast<int>(u);
            const float fx = u - static_cast<float>(left);
            const float* a = blocks_.data() + static_cast<std::size_t>(left) * c;
            const float* b = blocks_.data() + static_cast<std::size_t>(std::min(left + 1, across - 1)) * c;
            for (std::size_t k = 0; k < c; ++k) *d++ -= a[k] * (1 - fx) + b[k] * fx;
        }
    }
}

void ColourBackground::learn(std::vector<ColourImage> frames) {
    mean_.clear();
    if (frames.empty()) return;
    if (frames.size() > most_frames) {
        std::vector<ColourImage> some;
        for (std::size_t i = 0; i < most_frames; ++i) some.push_back(std::move(frames[i * frames.size() / most_frames]));
        frames = std::move(some);
    }
    width_ = frames[0].width;
    height_ = frames[0].height;
    scale_ = frames[0].scale;
    channels_ = 3;
    for (const ColourImage& frame : frames) channels_ = std::min(channels_, frame.channels);
    std::vector<std::vector<float>> logs;
    for (ColourImage& frame : frames) {
        if (frame.width != width_ || frame.height != height_) continue;
        if (channels_ == 1) make_grey(frame);
        to_log(frame, logs.emplace_back());
    }
    // The median, twice: the second time of frames in the light of the first.
    std::vector<float> values;
    for (int round = 0; round < 2; ++round) {
        if (round == 1 && logs.size() > 1) {
            for (auto& log : logs) {
                for (std::size_t i = 0; i < log.size(); ++i) log[i] -= mean_[i];
                solve_light(log);
                for (std::size_t i = 0; i < log.size(); ++i) log[i] += mean_[i];
            }
        }
        mean_.resize(logs[0].size());
        for (std::size_t i = 0; i < mean_.size(); ++i) {
            values.clear();
            for (const auto& log : logs) values.push_back(log[i]);
            mean_[i] = median(values);
        }
    }
    learn_noise(logs);
    add_shift_noise();
}

/// The median of the deviations, smoothed over the neighbourhood, for what compression and sensor do; of a single frame nothing is known.
void ColourBackground::learn_noise(const std::vector<std::vector<float>>& frames) {
    const auto c = static_cast<std::size_t>(channels_);
    noise_.assign(pixels(), 0.0f);
    if (frames.size() >= 3) {
        std::vector<float> values;
        for (std::size_t i = 0; i < pixels(); ++i) {
            values.clear();
            for (const auto& frame : frames) {
                for (std::size_t k = 0; k < c; ++k) values.push_back(std::abs(frame[i * c + k] - mean_[i * c + k]));
            }
            noise_[i] = 1.48f * median(values);
        }
        std::vector<float> raw = noise_;
        box_mean(raw, width_, height_, light_window, column_, noise_);
    }
    // Shot noise and rounding weigh more in the dark: a grey level there is a larger part.
    for (std::size_t i = 0; i < pixels(); ++i) {
        float level = 0;
        for (std::size_t k = 0; k < c; ++k) level += mean_[i * c + k] / static_cast<float>(c);
        const float grey = std::exp(level);
        const float least = settings_.least_noise * std::max(1.0f, std::sqrt(60.0f / grey));
        noise_[i] = std::hypot(noise_[i], least);
    }
}

/// Where the background has edges, a small shift of the picture is noise.
void ColourBackground::add_shift_noise() {
    const auto c = static_cast<std::size_t>(channels_);
    const auto line = static_cast<std::size_t>(width_);
    std::vector<float> squares(pixels(), 0.0f);
    for (std::size_t y = 1; y + 1 < static_cast<std::size_t>(height_); ++y) {
        for (std::size_t x = 1; x + 1 < line; ++x) {
            float steepest = 0;
            for (std::size_t k = 0; k < c; ++k) {
                const auto at = [&](std::size_t u, std::size_t v) { return mean_[(v * line + u) * c + k]; };
                const float across = 0.5f * (at(x + 1, y) - at(x - 1, y));
                const float down = 0.5f * (at(x, y + 1) - at(x, y - 1));
                steepest = std::max(steepest, across * across + down * down);
            }
            squares[y * line + x] = steepest;
        }
    }
    for (std::size_t i = 0; i < pixels(); ++i) noise_[i] = std::sqrt(noise_[i] * noise_[i] + settings_.shift * settings_.shift * squares[i]);
}

bool ColourBackground::compare(const ColourImage& frame, Evidence& evidence) {
    if (empty() || frame.width != width_ || frame.height != height_) return false;
    const ColourImage* used = &frame;
    if (frame.channels != channels_) {
        if (frame.channels == 1) {
            set_grey();
        } else {
            grey_ = frame;
            make_grey(grey_);
            used = &grey_;
        }
    }
    to_log(*used, difference_);
    for (std::size_t i = 0; i < difference_.size(); ++i) difference_[i] -= mean_[i];
    solve_light(difference_);
    evidence.width = width_;
    evidence.height = height_;
    evidence.scale = scale_;
    judge_pixels(evidence);
    if (evidence.with_colours) keep_colours(evidence);
    evidence.sum_up();
    return true;
}

/// How far a pixel's level is off that of the window around it or, at the border of something even, of the one beside it that is nearest.
float ColourBackground::unevenness(const std::vector<float>& levels, const std::vector<float>& means, int x, int y) const {
    const auto around = [&](int u, int v) { return means[static_cast<std::size_t>(std::clamp(v, 0, height_ - 1) * width_ + std::clamp(u, 0, width_ - 1))]; };
    const float level = levels[static_cast<std::size_t>(y * width_ + x)];
    float nearest = std::abs(level - around(x, y));
    for (const int side : {-light_window, light_window}) {
        nearest = std::min(nearest, std::abs(level - around(x + side, y)));
        nearest = std::min(nearest, std::abs(level - around(x, y + side)));
    }
    return nearest;
}

/// Posterior of three explanations of each pixel: the background; the background in another light, which is even around the pixel and has
/// nearly the same colour in all channels; something else, of any colour.
void ColourBackground::judge_pixels(Evidence& evidence) {
    const auto c = static_cast<std::size_t>(channels_);
    const float channels = static_cast<float>(channels_);
    level_.resize(pixels());
    seen_.resize(pixels());
    for (std::size_t i = 0; i < pixels(); ++i) {
        float sum = 0;
        float background = 0;
        for (std::size_t k = 0; k < c; ++k) sum += difference_[i * c + k];
        for (std::size_t k = 0; k < c; ++k) background += mean_[i * c + k];
        level_[i] = sum / channels;
        seen_[i] = (sum + background) / channels;
    }
    box_mean(level_, width_, height_, light_window, column_, around_);
    box_mean(seen_, width_, height_, light_window, column_, around_seen_);
    const float share_same = 1 - settings_.share_lit - settings_.share_other;
    const float other = settings_.share_other * std::pow(settings_.other_range, -channels);
    const float colour_variance = settings_.light_colour * settings_.light_colour;
    const float range = settings_.brightest - settings_.darkest;
    evidence.pixels.resize(pixels());
    evidence.perhaps.assign(pixels(), 0.0f);
    evidence.perhaps_counts = channels_ == 1;  // colours tell shadows from most things; what they leave open is for those who know more
    if (evidence.with_colours) evidence.as_background.resize(pixels());
    const float log_other = std::log(other / settings_.share_other);
    compare_structure();
    for (std::size_t i = 0; i < pixels(); ++i) {
        const float* d = difference_.data() + i * c;
        const float sigma = noise_[i];
        const float squares = squares_[i];
        if (squares < channels) {  // plainly the background
            evidence.pixels[i] = {0, 1};
            if (evidence.with_colours) evidence.as_background[i] = -0.5f * squares - channels * (0.5f * log_two_pi + std::log(sigma)) - log_other;
            continue;
        }
        float colour = 0;
        for (std::size_t k = 0; k < c; ++k) colour += (d[k] - level_[i]) * (d[k] - level_[i]);
        const float same = share_same * std::exp(-0.5f * squares - channels * (0.5f * log_two_pi + std::log(sigma)));
        const float rough = roughness(i);
        const float beyond = around_[i] < 0 ? std::max(settings_.darkest - around_[i], 0.0f) : std::max(around_[i] - settings_.brightest, 0.0f);
        const float ends = beyond / settings_.light_spread;
        float log_lit = -0.5f * (uneven_[i] * uneven_[i] / (rough * rough) + ends * ends) - std::log(rough) - 0.5f * log_two_pi - std::log(range);
        // Of one colour with the background.
        const float log_alike = channels_ > 1 ? -0.5f * colour / colour_variance - (channels - 1) * (0.5f * log_two_pi + 0.5f * std::log(colour_variance)) : 0;
        log_lit += log_alike;
        // Does the background's structure go on here in another light? That it does not says less: dark and worn floors lose theirs, too.
        const float structure = std::clamp(settings_.structure_weight * around_structure_[i] * window_pixels, 0.0f, settings_.most_structure);
        const float lit = settings_.share_lit * std::exp(log_lit + structure);
        // Something else has any colour, or the background's; its surface may be as even as a shadow, but then in itself and not beside the background.
        const float log_even = -0.5f * even_[i] * even_[i] / (rough * rough) - std::log(rough) - 0.5f * log_two_pi;
        const float part = settings_.even_things;
        const float something = other * (1 - part) + part * settings_.share_other / settings_.other_range * std::exp(log_even + log_alike);
        const float sum = something + same + lit;
        const float perhaps = settings_.perhaps * std::min(something, lit) / sum;
        const float floor = structure > 0 ? 1 - std::exp(-structure) : 0;  // a shadow on the background is the background
        evidence.perhaps[i] = perhaps;
        evidence.pixels[i] = {std::max(something - lit, 0.0f) / sum + (evidence.perhaps_counts ? perhaps : 0),
                              (same + floor * std::max(lit - something, 0.0f)) / sum};
        if (evidence.with_colours) evidence.as_background[i] = std::log(std::max((same + lit) / (1 - settings_.share_other), 1e-30f)) - log_other;
    }
}

/// Over how much a pixel's level varies beside its neighbours' by noise alone.
float ColourBackground::roughness(std::size_t i) const { return 1.41421356f * std::max(noise_[i], 0.03f); }

/// Of pixels that are not plainly the background: is the picture divided by the background the evener one, as under a shadow, or the picture itself, as
/// on a thing? One pixel tells little, a neighbourhood much, wherever the background has structure.
void ColourBackground::compare_structure() {
    const auto c = static_cast<std::size_t>(channels_);
    const float channels = static_cast<float>(channels_);
    squares_.resize(pixels());
    uneven_.resize(pixels());
    even_.resize(pixels());
    structure_.assign(pixels(), 0.0f);
    for (std::size_t i = 0; i < pixels(); ++i) {
        const float* d = difference_.data() + i * c;
        float squares = 0;
        for (std::size_t k = 0; k < c; ++k) squares += d[k] * d[k];
        squares_[i] = squares / (noise_[i] * noise_[i]);
        if (squares_[i] < channels) continue;
        const int x = static_cast<int>(i) % width_;
        const int y = static_cast<int>(i) / width_;
        uneven_[i] = unevenness(level_, around_, x, y);
        even_[i] = unevenness(seen_, around_seen_, x, y);
        const float rough = roughness(i);
        structure_[i] =
            std::clamp(0.5f * (even_[i] * even_[i] - uneven_[i] * uneven_[i]) / (rough * rough), -settings_.pixel_structure, settings_.pixel_structure);
    }
    box_mean(structure_, width_, height_, structure_window, column_, around_structure_);
}

/// The frame's colours as they would be in the background's light.
void ColourBackground::keep_colours(Evidence& evidence) const {
    evidence.channels = channels_;
    evidence.colour_range = static_cast<double>(settings_.other_range);
    evidence.colours.resize(difference_.size());
    for (std::size_t i = 0; i < difference_.size(); ++i) evidence.colours[i] = mean_[i] + difference_[i];
}

void ColourBackground::refresh(const Evidence& evidence, float part) {
    if (difference_.size() != mean_.size()) return;
    constexpr float surely = 0.95f;
    const auto c = static_cast<std::size_t>(channels_);
    for (std::size_t i = 0; i < pixels(); ++i) {
        if (evidence.pixels[i].plain < surely || std::abs(level_[i]) > 3 * noise_[i]) continue;
        for (std::size_t k = 0; k < c; ++k) mean_[i * c + k] += part * difference_[i * c + k];
    }
}

void ColourFrames::add(const ColourImage& frame) {
    if (offered_++ % step_ != 0 || frame.empty()) return;
    if (frames_.size() == most_) {  // every second one is kept, and from now on only half as many are taken
        for (std::size_t i = 1; 2 * i < frames_.size(); ++i) frames_[i] = std::move(frames_[2 * i]);
        frames_.resize((frames_.size() + 1) / 2);
        step_ *= 2;
        if ((offered_ - 1) % step_ != 0) return;
    }
    frames_.push_back(frame);
}

}  // namespace roomfix
