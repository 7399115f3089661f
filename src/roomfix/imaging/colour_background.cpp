#include "roomfix/imaging/colour_background.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "roomfix/base/column_sort.hpp"
#include "roomfix/base/fast_math.hpp"
#include "roomfix/base/median.hpp"

namespace roomfix {
namespace {

constexpr int block = 48;            // px, edge of the squares that share a light
constexpr int light_window = 3;      // px to each side over which a shadow's light is even
constexpr int structure_window = 5;  // px to each side over which structure is compared
constexpr float window_pixels = (2 * structure_window + 1) * (2 * structure_window + 1);
constexpr std::size_t most_frames = 24;
constexpr float log_two_pi = 1.8378771f;

int blocks_along(int length) { return (length + block - 1) / block; }

/// Of those values that are less than `limit` off a number.
struct MedianNear {
    float value = 0;
    int count = 0;
};

/// Counts them in bins, evenly spread in each.
MedianNear median_near(std::span<const float> values, float number, float limit) {
    constexpr int bins = 128;
    std::array<int, bins + 2> counts{};  // the first and the last: of those farther off
    const float per_value = 0.5f * bins / limit;
    for (const float v : values) {
        const float bin = std::min(std::max((v - number) * per_value + 0.5f * bins + 1, 0.0f), bins + 1.5f);
        ++counts[static_cast<std::size_t>(bin)];
    }
    MedianNear median{number, static_cast<int>(values.size()) - counts[0] - counts[bins + 1]};
    float left = 0.5f * static_cast<float>(median.count);
    for (std::size_t b = 1; b <= bins && median.count > 0; ++b) {
        const auto here = static_cast<float>(counts[b]);
        if (here >= left) {
            median.value = number + (static_cast<float>(b) - 1 + left / here - 0.5f * bins) / per_value;
            break;
        }
        left -= here;
    }
    return median;
}

/// Means over squares of 2 * window + 1 pixels, cut off at the picture's borders. `columns`: working memory.
template <int window>
void box_mean(const std::vector<float>& from, int width, int height, std::vector<float>& columns, std::vector<float>& to) {
    const auto line = static_cast<std::size_t>(width);
    to.resize(from.size());
    // Sums of the columns, with zeros beside the picture, and behind them what part each pixel of a row is of its window.
    columns.assign(2 * line + 2 * window, 0.0f);
    float* sums = columns.data() + window;
    float* share = columns.data() + line + 2 * window;
    for (int x = 0; x < width; ++x) share[x] = 1 / static_cast<float>(std::min(x + window, width - 1) - std::max(x - window, 0) + 1);
    const auto add = [&](int y, float sign) {
        const float* row = from.data() + static_cast<std::ptrdiff_t>(y) * width;
        for (std::size_t x = 0; x < line; ++x) sums[x] += sign * row[x];
    };
    for (int y = 0; y < std::min(window, height); ++y) add(y, 1);
    for (int y = 0; y < height; ++y) {
        if (y + window < height) add(y + window, 1);
        if (y - window - 1 >= 0) add(y - window - 1, -1);
        const float rows = 1 / static_cast<float>(std::min(y + window, height - 1) - std::max(y - window, 0) + 1);
        const float* begin = columns.data();
        float* row = to.data() + static_cast<std::ptrdiff_t>(y) * width;
        for (std::size_t x = 0; x < line; ++x) {
            float sum = begin[x];
            for (std::size_t k = 1; k <= 2 * window; ++k) sum += begin[x + k];
            row[x] = sum * share[x] * rows;
        }
    }
}

/// Of each pixel: the mean of the channels' differences, that of what is seen, and the sum of the squares of the differences over their noise. The arrays do
/// not overlap: several pixels go at once.
template <std::size_t channels>
void measure_levels(std::size_t count, const float* __restrict difference, const float* __restrict mean, const float* __restrict inverse_noise,
                    float* __restrict level, float* __restrict seen, float* __restrict squares) {
    constexpr float share = 1.0f / channels;
    for (std::size_t i = 0; i < count; ++i) {
        float sum = 0, sum_of_squares = 0;
        for (std::size_t k = 0; k < channels; ++k) {
            const float d = difference[channels * i + k];
            sum += d;
            sum_of_squares += d * d;
        }
        float sum_seen = sum;
        for (std::size_t k = 0; k < channels; ++k) sum_seen += mean[channels * i + k];
        level[i] = sum * share;
        seen[i] = sum_seen * share;
        squares[i] = sum_of_squares * inverse_noise[i] * inverse_noise[i];
    }
}

}  // namespace

/// Some changed pixels side by side, so that loops over them run several at once.
struct ColourBackground::Batch {
    static constexpr std::size_t most = 128;
    using Values = std::array<float, most>;
    Values squares, colour, log_sigma, rough, around, uneven, even, structure;
    Values other, plain, perhaps, as_background;
};

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
    // Every ninth pixel of each block and channel.
    samples_.clear();
    first_sample_.clear();
    for (int by = 0; by < down; ++by) {
        for (int bx = 0; bx < across; ++bx) {
            const int right = std::min((bx + 1) * block, width_);
            const int bottom = std::min((by + 1) * block, height_);
            for (std::size_t k = 0; k < c; ++k) {
                first_sample_.push_back(samples_.size());
                for (int y = by * block; y < bottom; y += 3) {
                    const float* row = difference.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) * c + k;
                    for (int x = bx * block + (y / 3) % 3; x < right; x += 3) samples_.push_back(row[static_cast<std::size_t>(x) * c]);
                }
            }
        }
    }
    first_sample_.push_back(samples_.size());
    smooth_.resize(count * c);
    for (std::size_t b = 0; b < count; ++b) {
        for (std::size_t k = 0; k < c; ++k) smooth_[b * c + k] = all[k];
    }
    blocks_.resize(count * c);
    weights_.resize(count);
    for (const float limit : {settings_.static_limit, settings_.static_close, settings_.static_close}) {
        for (std::size_t b = 0; b < count; ++b) {
            float still = 0;
            for (std::size_t k = 0; k < c; ++k) {
                const float light = smooth_[b * c + k];
                const std::size_t begin = first_sample_[b * c + k], end = first_sample_[b * c + k + 1];
                const MedianNear near = median_near({samples_.data() + begin, end - begin}, light, limit);
                still += static_cast<float>(near.count);
                blocks_[b * c + k] = near.count > 16 ? near.value : light;
            }
            const auto seen = static_cast<float>(first_sample_[(b + 1) * c] - first_sample_[b * c]);
            const float part = seen > 0 ? still / seen : 0;
            weights_[b] = part * part;
        }
        couple_blocks(across, down, all);
    }
    subtract_light(across, down, difference);
}

/// Bilinear between the blocks' middles: along the blocks' rows first.
void ColourBackground::subtract_light(int across, int down, std::vector<float>& difference) {
    const auto c = static_cast<std::size_t>(channels_);
    const std::size_t line = static_cast<std::size_t>(width_) * c;
    along_.resize(static_cast<std::size_t>(down) * line);
    for (int x = 0; x < width_; ++x) {
        const float u = std::clamp((static_cast<float>(x) + 0.5f) / block - 0.5f, 0.0f, static_cast<float>(across - 1));
        const auto left = static_cast<std::size_t>(u);
        const std::size_t right = std::min(left + 1, static_cast<std::size_t>(across) - 1);
        const float part = u - static_cast<float>(left);
        for (std::size_t by = 0; by < static_cast<std::size_t>(down); ++by) {
            const float* row = smooth_.data() + by * static_cast<std::size_t>(across) * c;
            float* to = along_.data() + by * line + static_cast<std::size_t>(x) * c;
            for (std::size_t k = 0; k < c; ++k) to[k] = row[left * c + k] * (1 - part) + row[right * c + k] * part;
        }
    }
    for (int y = 0; y < height_; ++y) {
        const float v = std::clamp((static_cast<float>(y) + 0.5f) / block - 0.5f, 0.0f, static_cast<float>(down - 1));
        const auto top = static_cast<std::size_t>(v);
        const float* a = along_.data() + top * line;
        const float* b = along_.data() + std::min(top + 1, static_cast<std::size_t>(down) - 1) * line;
        const float part = v - static_cast<float>(top);
        float* d = difference.data() + static_cast<std::size_t>(y) * line;
        for (std::size_t i = 0; i < line; ++i) d[i] -= a[i] * (1 - part) + b[i] * part;
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
    std::vector<ColumnRow> values(logs.size());
    for (int round = 0; round < 2; ++round) {
        if (round == 1 && logs.size() > 1) {
            for (auto& log : logs) {
                for (std::size_t i = 0; i < log.size(); ++i) log[i] -= mean_[i];
                solve_light(log);
                for (std::size_t i = 0; i < log.size(); ++i) log[i] += mean_[i];
            }
        }
        mean_.resize(logs[0].size());
        for (std::size_t first = 0; first < mean_.size(); first += columns_together) {
            const std::size_t count = std::min(columns_together, mean_.size() - first);
            for (std::size_t f = 0; f < logs.size(); ++f) std::copy_n(logs[f].begin() + static_cast<std::ptrdiff_t>(first), count, values[f].begin());
            sort_columns(values);
            std::copy_n(values[values.size() / 2].begin(), count, mean_.begin() + static_cast<std::ptrdiff_t>(first));
        }
    }
    learn_noise(logs);
    add_shift_noise();
    keep_noise();
}

/// What every frame asks of the noise.
void ColourBackground::keep_noise() {
    inverse_noise_.resize(pixels());
    log_noise_.resize(pixels());
    for (std::size_t i = 0; i < pixels(); ++i) {
        inverse_noise_[i] = 1 / noise_[i];
        log_noise_[i] = std::log(noise_[i]);
    }
}

/// The median of the deviations, smoothed over the neighbourhood, for what compression and sensor do; of a single frame nothing is known.
void ColourBackground::learn_noise(const std::vector<std::vector<float>>& frames) {
    const auto c = static_cast<std::size_t>(channels_);
    noise_.assign(pixels(), 0.0f);
    if (frames.size() >= 3) {
        std::vector<ColumnRow> values(frames.size() * c);
        for (std::size_t first = 0; first < pixels(); first += columns_together) {
            const std::size_t count = std::min(columns_together, pixels() - first);
            for (std::size_t v = 0; v < values.size(); ++v) {
                const float* of_frame = frames[v / c].data() + first * c + v % c;
                const float* mean = mean_.data() + first * c + v % c;
                for (std::size_t i = 0; i < count; ++i) values[v][i] = std::abs(of_frame[i * c] - mean[i * c]);
            }
            sort_columns(values);
            for (std::size_t i = 0; i < count; ++i) noise_[first + i] = 1.48f * values[values.size() / 2][i];
        }
        std::vector<float> raw = noise_;
        box_mean<light_window>(raw, width_, height_, column_, noise_);
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

ColourImage ColourBackground::picture() const {
    ColourImage image{width_, height_, channels_, scale_, {}};
    image.values.reserve(mean_.size());
    for (const float log : mean_) image.values.push_back(static_cast<std::uint8_t>(std::clamp(std::exp(log) - settings_.dark + 0.5f, 0.0f, 255.0f)));
    return image;
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

/// What of a frame is not plainly its background.
void ColourBackground::find_changed() {
    const std::size_t count = pixels();
    level_.resize(count);
    seen_.resize(count);
    squares_.resize(count);
    const auto measure = channels_ == 1 ? measure_levels<1> : measure_levels<3>;
    measure(count, difference_.data(), mean_.data(), inverse_noise_.data(), level_.data(), seen_.data(), squares_.data());
    changed_.resize(count);
    std::size_t kept = 0;
    const auto limit = static_cast<float>(channels_);
    for (std::size_t i = 0; i < count; ++i) {
        changed_[kept] = static_cast<int>(i);
        kept += !(squares_[i] < limit);
    }
    changed_.resize(kept);
}

/// How far a pixel's level is off that of the window around it or, at the border of something even, of the one beside it that is nearest.
float ColourBackground::unevenness(const std::vector<float>& levels, const std::vector<float>& means, int x, int y) const {
    const int i = y * width_ + x;
    const float level = levels[static_cast<std::size_t>(i)];
    const auto off = [&](int at) { return std::abs(level - means[static_cast<std::size_t>(at)]); };
    const int left = std::min(light_window, x), right = std::min(light_window, width_ - 1 - x);
    const int above = std::min(light_window, y), below = std::min(light_window, height_ - 1 - y);
    return std::min({off(i), off(i - left), off(i + right), off(i - above * width_), off(i + below * width_)});
}

/// Posterior of three explanations of each pixel: the background; the background in another light, which is even around the pixel and has
/// nearly the same colour in all channels; something else, of any colour.
void ColourBackground::judge_pixels(Evidence& evidence) {
    find_changed();
    box_mean<light_window>(level_, width_, height_, column_, around_);
    box_mean<light_window>(seen_, width_, height_, column_, around_seen_);
    compare_structure();
    evidence.pixels.assign(pixels(), {0, Evidence::certain});
    evidence.perhaps.assign(pixels(), 0);
    evidence.light.assign(pixels(), 0);
    evidence.perhaps_part = settings_.perhaps;
    evidence.perhaps_counts = channels_ == 1;  // colours tell shadows from most things; what they leave open is for those who know more
    const float channels = static_cast<float>(channels_);
    const float log_other = -channels * std::log(settings_.other_range);  // of one colour of a thing's
    if (evidence.with_colours) {
        evidence.as_background.resize(pixels());
        for (std::size_t i = 0; i < pixels(); ++i) {
            evidence.as_background[i] = -0.5f * squares_[i] - channels * (0.5f * log_two_pi + log_noise_[i]) - log_other;
        }
    }
    const auto c = static_cast<std::size_t>(channels_);
    Batch batch;
    for (std::size_t first = 0; first < changed_.size(); first += Batch::most) {
        const std::size_t count = std::min(Batch::most, changed_.size() - first);
        for (std::size_t j = 0; j < Batch::most; ++j) {
            const auto i = static_cast<std::size_t>(changed_[first + std::min(j, count - 1)]);
            const float* d = difference_.data() + i * c;
            float colour = 0;
            for (std::size_t k = 0; k < c; ++k) colour += (d[k] - level_[i]) * (d[k] - level_[i]);
            batch.colour[j] = colour;
            batch.squares[j] = squares_[i];
            batch.log_sigma[j] = log_noise_[i];
            batch.rough[j] = roughness(i);
            batch.around[j] = around_[i];
            batch.uneven[j] = uneven_[i];
            batch.even[j] = even_[i];
            batch.structure[j] = around_structure_[i];
        }
        judge(batch);
        for (std::size_t j = 0; j < count; ++j) {
            const auto i = static_cast<std::size_t>(changed_[first + j]);
            evidence.perhaps[i] = Evidence::parts(batch.perhaps[j]);
            evidence.light[i] = static_cast<std::int8_t>(std::clamp(100 * level_[i], -127.0f, 127.0f));
            evidence.pixels[i] = {Evidence::parts(batch.other[j]), Evidence::parts(batch.plain[j])};
            if (evidence.perhaps_counts) evidence.pixels[i].other += evidence.counted(evidence.perhaps[i]);
            if (evidence.with_colours) evidence.as_background[i] = batch.as_background[j] - log_other;
        }
    }
}

void ColourBackground::judge(Batch& batch) const {
    const EvidenceSettings settings = settings_;  // a copy that nothing written below can change: then several pixels go at once
    const auto channels = static_cast<float>(channels_);
    const float share_same = 1 - settings.share_lit - settings.share_other;
    const float other = settings.share_other * std::pow(settings.other_range, -channels);
    const float colour_variance = settings.light_colour * settings.light_colour;
    const float log_range = std::log(settings.brightest - settings.darkest);
    // Of one colour with the background.
    const float one_colour = channels_ > 1 ? -0.5f / colour_variance : 0;
    const float colours = channels_ > 1 ? -(channels - 1) * (0.5f * log_two_pi + 0.5f * std::log(colour_variance)) : 0;
    for (std::size_t j = 0; j < Batch::most; ++j) {
        const float rough = batch.rough[j];
        const float log_rough = fast_log(rough) + 0.5f * log_two_pi;
        const float inverse = 0.5f / (rough * rough);
        const float same = share_same * fast_exp(-0.5f * batch.squares[j] - channels * (0.5f * log_two_pi + batch.log_sigma[j]));
        const float beyond = std::max(std::max(settings.darkest - batch.around[j], batch.around[j] - settings.brightest), 0.0f);
        const float ends = beyond / settings.light_spread;
        const float log_alike = one_colour * batch.colour[j] + colours;
        const float log_lit = -inverse * batch.uneven[j] * batch.uneven[j] - 0.5f * ends * ends - log_rough - log_range + log_alike;
        // Does the background's structure go on here in another light? That it does not says less: dark and worn floors lose theirs, too.
        const float structure = std::min(std::max(settings.structure_weight * batch.structure[j] * window_pixels, 0.0f), settings.most_structure);
        const float lit = settings.share_lit * fast_exp(log_lit + structure);
        // Something else has any colour, or the background's; its surface may be as even as a shadow, but then in itself and not beside the background.
        const float log_even = -inverse * batch.even[j] * batch.even[j] - log_rough + log_alike;
        const float part = settings.even_things;
        const float something = other * (1 - part) + part * settings.share_other / settings.other_range * fast_exp(log_even);
        const float sum = something + same + lit;
        const float floor = 1 - fast_exp(-structure);  // a shadow on the background is the background
        batch.perhaps[j] = std::min(something, lit) / sum;
        batch.other[j] = std::max(something - lit, 0.0f) / sum;
        batch.plain[j] = (same + floor * std::max(lit - something, 0.0f)) / sum;
        batch.as_background[j] = fast_log(std::max((same + lit) / (1 - settings.share_other), 1e-30f));
    }
}

/// Over how much a pixel's level varies beside its neighbours' by noise alone.
float ColourBackground::roughness(std::size_t i) const { return 1.41421356f * std::max(noise_[i], 0.03f); }

/// Of pixels that are not plainly the background: is the picture divided by the background the evener one, as under a shadow, or the picture itself, as
/// on a thing? One pixel tells little, a neighbourhood much, wherever the background has structure.
void ColourBackground::compare_structure() {
    uneven_.resize(pixels());
    even_.resize(pixels());
    structure_.assign(pixels(), 0.0f);
    int y = 0;
    for (const int at : changed_) {  // row by row
        while (at >= (y + 1) * width_) ++y;
        const int x = at - y * width_;
        const auto i = static_cast<std::size_t>(at);
        uneven_[i] = unevenness(level_, around_, x, y);
        even_[i] = unevenness(seen_, around_seen_, x, y);
        const float rough = roughness(i);
        structure_[i] =
            std::clamp(0.5f * (even_[i] * even_[i] - uneven_[i] * uneven_[i]) / (rough * rough), -settings_.pixel_structure, settings_.pixel_structure);
    }
    box_mean<structure_window>(structure_, width_, height_, column_, around_structure_);
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
    constexpr int surely = 95 * Evidence::certain / 100;
    constexpr std::size_t turns = 4;
    const auto c = static_cast<std::size_t>(channels_);
    const auto line = static_cast<std::size_t>(width_);
    for (std::size_t y = turn_; y < static_cast<std::size_t>(height_); y += turns) {
        for (std::size_t i = y * line; i < (y + 1) * line; ++i) {
            const bool keeps = evidence.pixels[i].plain < surely || std::abs(level_[i]) * inverse_noise_[i] > 3;
            const float step = keeps ? 0 : turns * part;
            for (std::size_t k = 0; k < c; ++k) mean_[i * c + k] += step * difference_[i * c + k];
        }
    }
    turn_ = (turn_ + 1) % turns;
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
