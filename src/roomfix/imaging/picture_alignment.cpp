#include "roomfix/imaging/picture_alignment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "roomfix/geometry/pose.hpp"

namespace roomfix {
namespace {

using MotionMatrix = Eigen::Matrix<double, motion_parameters, motion_parameters>;

float squared(float value) { return value * value; }

}  // namespace

std::optional<Eigen::Vector2d> seen_after(const CameraModel& model, const Eigen::Vector2d& ray, const PictureMotion& motion) {
    const Eigen::Vector3d after = exponential_rotation(-motion.head<3>()) * Eigen::Vector3d(ray.x(), ray.y(), 1);
    const auto pixel = project(model, after);
    if (!pixel) return std::nullopt;
    const Eigen::Vector2d middle(model.cx, model.cy);
    return Eigen::Vector2d(middle + (1 + motion[3]) * (*pixel - middle));
}

void PictureAlignment::Logs::resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    values.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

void PictureAlignment::shrink(LumaView picture, Logs& logs) {
    logs.resize(picture.width / factor_, picture.height / factor_);
    sums_.resize(static_cast<std::size_t>(logs.width));
    const int share = 16 * 65536 / (factor_ * factor_);  // sixteenths of a grey level per level summed up, in parts of 65536
    float* to = logs.values.data();
    for (int y = 0; y < logs.height; ++y) {
        std::fill(sums_.begin(), sums_.end(), 0);
        for (int line = 0; line < factor_; ++line) {
            const std::uint8_t* from = picture.row(y * factor_ + line);
            for (int& sum : sums_) {
                for (int i = 0; i < factor_; ++i) sum += *from++;
            }
        }
        for (const int sum : sums_) *to++ = log_of_[static_cast<std::size_t>((static_cast<std::int64_t>(sum) * share) >> 16)];
    }
}

void PictureAlignment::halve(const Logs& logs, Logs& half) {
    half.resize(logs.width / 2, logs.height / 2);
    float* to = half.values.data();
    for (int y = 0; y < half.height; ++y) {
        const float* above = logs.at(0, 2 * y);
        const float* below = above + logs.width;
        for (int x = 0; x < half.width; ++x) *to++ = 0.25f * (above[2 * x] + above[2 * x + 1] + below[2 * x] + below[2 * x + 1]);
    }
}

void PictureAlignment::fill_pyramid(LumaView picture, Logs Level::*which) {
    shrink(picture, levels_[0].*which);
    for (std::size_t i = 1; i < levels; ++i) halve(levels_[i - 1].*which, levels_[i].*which);
}

void PictureAlignment::set_reference(LumaView reference) {
    factor_ = (reference.width + settings_.width - 1) / settings_.width;
    for (std::size_t i = 0; i < log_of_.size(); ++i) log_of_[i] = std::log(static_cast<float>(i) / 16 + settings_.dark);
    fill_pyramid(reference, &Level::reference);
    for (Level& level : levels_) {
        const Logs& logs = level.reference;
        level.slope_x.assign(logs.values.size(), 0.0f);
        level.slope_y.assign(logs.values.size(), 0.0f);
        for (int y = 1; y + 1 < logs.height; ++y) {
            for (int x = 1; x + 1 < logs.width; ++x) {
                const auto i = static_cast<std::size_t>(logs.at(x, y) - logs.values.data());
                level.slope_x[i] = 0.5f * (*logs.at(x + 1, y) - *logs.at(x - 1, y));
                level.slope_y[i] = 0.5f * (*logs.at(x, y + 1) - *logs.at(x, y - 1));
            }
        }
    }
    blocks_.clear();
    constexpr int border = 1 << (levels - 1);
    const Logs& logs = levels_[0].reference;
    for (int y = border; y + block_size + border <= logs.height; y += block_size) {
        for (int x = border; x + block_size + border <= logs.width; x += block_size) add_block(x, y);
    }
    ratios_.resize(blocks_.size());
    found_ = {};
}

/// If it has structure.
void PictureAlignment::add_block(int x, int y) {
    Block block;
    block.x = x;
    block.y = y;
    double sum = 0, squares = 0;  // of the logarithms
    for (std::size_t l = 0; l < levels; ++l) {
        const Level& level = levels_[l];
        const int size = block_size >> l;
        const auto count = static_cast<float>(size * size);
        Eigen::Vector2f mean = Eigen::Vector2f::Zero();
        block.slopes[l].setZero();
        for (int v = y >> l; v < (y >> l) + size; ++v) {
            for (int u = x >> l; u < (x >> l) + size; ++u) {
                const float* at = level.reference.at(u, v);
                const auto i = static_cast<std::size_t>(at - level.reference.values.data());
                const Eigen::Vector2f slope(level.slope_x[i], level.slope_y[i]);
                block.slopes[l] += slope * slope.transpose();
                mean += slope / count;
                if (l > 0) continue;
                sum += static_cast<double>(*at);
                squares += static_cast<double>(*at) * static_cast<double>(*at);
            }
        }
        block.slopes[l] -= count * mean * mean.transpose();
    }
    constexpr double count = block_size * block_size;
    const float slope = block.slopes[0].trace() / static_cast<float>(count);
    if (slope < squared(settings_.least_slope)) return;
    block.expected =
        squared(settings_.level_noise) * static_cast<float>(std::exp(-2 * sum / count)) + squared(settings_.colour_noise) + squared(settings_.blur) * slope;
    block.other = 2 * static_cast<float>(squares / count - sum / count * sum / count);  // another place with as much structure
    block.middle = factor_ * (Eigen::Vector2d(x, y) + Eigen::Vector2d::Constant(0.5 * block_size)) - Eigen::Vector2d(0.5, 0.5);
    const auto ray = unproject(model_, block.middle);
    if (!ray) return;
    block.ray = *ray;
    constexpr double step = 1e-5;
    for (int i = 0; i < motion_parameters; ++i) {
        const auto pixel = seen_after(model_, block.ray, step * PictureMotion::Unit(i));
        if (!pixel) return;
        block.jacobian.col(i) = (*pixel - block.middle) / step;
    }
    blocks_.push_back(block);
}

PictureMotion PictureAlignment::inverse_variances() const {
    PictureMotion sigmas = PictureMotion::Constant(settings_.most_turned);
    sigmas[3] = settings_.most_grown;
    return sigmas.cwiseAbs2().cwiseInverse();
}

PictureAlignment::Residual PictureAlignment::residual(int number, const Block& block, const PictureMotion& motion) const {
    const Level& level = levels_[static_cast<std::size_t>(number)];
    const int size = block_size >> number;
    const auto pixel = seen_after(model_, block.ray, motion);
    if (!pixel) return {};
    const Eigen::Vector2d shift = (*pixel - block.middle) / (factor_ << number);
    const double column = std::floor(shift.x()), line = std::floor(shift.y());
    const double x0 = (block.x >> number) + column, y0 = (block.y >> number) + line;
    if (!(x0 >= 0 && y0 >= 0 && x0 + size < level.picture.width && y0 + size < level.picture.height)) return {};
    const float right = static_cast<float>(shift.x() - column), down = static_cast<float>(shift.y() - line);
    float sum = 0, squares = 0, sum_x = 0, sum_y = 0, mean_x = 0, mean_y = 0;
    for (int y = 0; y < size; ++y) {
        const float* above = level.picture.at(static_cast<int>(x0), static_cast<int>(y0) + y);
        const float* below = above + level.picture.width;
        const float* there = level.reference.at(block.x >> number, (block.y >> number) + y);
        const std::ptrdiff_t at = there - level.reference.values.data();
        const float* slope_x = level.slope_x.data() + at;
        const float* slope_y = level.slope_y.data() + at;
        for (int x = 0; x < size; ++x) {
            const float upper = above[x] + right * (above[x + 1] - above[x]), lower = below[x] + right * (below[x + 1] - below[x]);
            const float left = upper + down * (lower - upper) - there[x];
            sum += left;
            squares += left * left;
            sum_x += left * slope_x[x];
            sum_y += left * slope_y[x];
            mean_x += slope_x[x];
            mean_y += slope_y[x];
        }
    }
    const auto count = static_cast<float>(size * size);
    const float mean = sum / count;
    return {std::max(squares / count - mean * mean, 0.0f), {sum_x - mean * mean_x, sum_y - mean * mean_y}};
}

/// Gauss-Newton from the coarsest level given to the finest; what shows something else weighs less and less.
PictureMotion PictureAlignment::refined(PictureMotion motion, int coarsest) const {
    constexpr int steps = 6;  // on each level
    for (int level = coarsest; level >= 0; --level) {
        for (int step = 0; step < steps; ++step) {
            const float off = std::max(settings_.blur, 1 - 0.3f * static_cast<float>(step));  // px of the level that the motion may still be off
            MotionMatrix information = inverse_variances().asDiagonal();
            PictureMotion gradient = inverse_variances().cwiseProduct(motion);
            const double pixels = factor_ << level;  // of the full picture
            for (const Block& block : blocks_) {
                const Residual there = residual(level, block, motion);
                if (there.variance < 0) continue;
                const Eigen::Matrix2f& slopes = block.slopes[static_cast<std::size_t>(level)];
                const int size = block_size >> level;
                const float expected = block.expected + squared(off) * slopes.trace() / static_cast<float>(size * size);
                const float weight = 1 / squared(1 + there.variance / expected) / expected / settings_.same_noise;
                information += block.jacobian.transpose() * (weight * slopes).cast<double>() * block.jacobian / (pixels * pixels);
                gradient += block.jacobian.transpose() * (weight * there.gradient).cast<double>() / pixels;
            }
            const PictureMotion change = information.ldlt().solve(gradient);
            motion -= change;
            if (!motion.allFinite()) return PictureMotion::Zero();
            if (off <= settings_.blur && offset_of(change) < 0.02 * pixels) break;
        }
    }
    return motion;
}

/// px of the full picture, root mean square over the blocks.
double PictureAlignment::offset_of(const PictureMotion& motion) const {
    double sum = 0;
    for (const Block& block : blocks_) sum += (block.jacobian * motion).squaredNorm();
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(blocks_.size(), 1)));
}

/// Log of how likely it is that a block leaves that much, in units in which one that shows the reference exactly has about 0: it shows the reference, or
/// something else, and then whatever it leaves says nothing.
float PictureAlignment::block_nats(float left, float expected, float other) const {
    constexpr float pixels = block_size * block_size;
    const float half = 0.5f * pixels / settings_.same_noise;
    const float same = std::log(1 - settings_.share_other) - half * (left / expected - 1);
    const float another = std::log(settings_.share_other) - half * std::log(other / expected);
    const float more = std::max(same, another);
    return more + std::log1p(std::exp(std::min(same, another) - more));
}

void PictureAlignment::weigh(const PictureMotion& motion, Alignment& found) {
    found.motion = motion;
    found.offset = offset_of(motion);
    std::size_t seen = 0;
    for (Block& block : blocks_) {
        block.left = residual(0, block, motion).variance;
        if (block.left >= 0) ratios_[seen++] = block.left / block.expected;
    }
    found.nats = 0;
    found.showing = 0;
    if (seen < blocks_.size() / 4 + 1) return;  // it would show hardly anything of the reference
    // Pictures that are noisier than expected (much compressed, out of focus) are so everywhere.
    const auto quarter = ratios_.begin() + static_cast<std::ptrdiff_t>(seen / 4);
    std::nth_element(ratios_.begin(), quarter, ratios_.begin() + static_cast<std::ptrdiff_t>(seen));
    const float noisier = std::clamp(*quarter, 1.0f, 4.0f);
    std::size_t showing = 0;
    for (const Block& block : blocks_) {
        if (block.left < 0 || block.still < 0) continue;
        const float expected = noisier * block.expected, other = std::max(block.other, 4 * expected);
        const float here = block_nats(block.left, expected, other), still = block_nats(block.still, expected, other);
        showing += block.left / expected < 1 + std::log(other / expected);
        found.nats += static_cast<double>(std::clamp(here - still, -settings_.most_nats, settings_.most_nats));
    }
    found.showing = static_cast<double>(showing) / static_cast<double>(seen);
}

/// How well the smallest picture, shifted, shows the reference, nats.
float PictureAlignment::score_at(int dx, int dy) const {
    constexpr int size = 8;  // px
    constexpr float count = size * size;
    const Level& level = levels_.back();
    const float floor = squared(settings_.least_slope);
    float score = 0;
    for (int top = 0; top + size <= level.reference.height; top += size) {
        for (int left = 0; left + size <= level.reference.width; left += size) {
            if (left + dx < 0 || top + dy < 0 || left + dx + size > level.picture.width || top + dy + size > level.picture.height) continue;
            float sum = 0, squares = 0, levels = 0, level_squares = 0;
            for (int y = top; y < top + size; ++y) {
                const float* there = level.reference.at(left, y);
                const float* here = level.picture.at(left + dx, y + dy);
                for (int x = 0; x < size; ++x) {
                    const float difference = here[x] - there[x];
                    sum += difference;
                    squares += difference * difference;
                    levels += there[x];
                    level_squares += there[x] * there[x];
                }
            }
            const float rest = squares / count - squared(sum / count), structure = level_squares / count - squared(levels / count);
            score +=
                std::clamp(0.5f * count / settings_.same_noise * std::log((structure + floor) / (rest + floor)), -settings_.most_nats, settings_.most_nats);
        }
    }
    return score;
}

/// The shift of the whole picture at which it shows the reference best, as a motion.
PictureMotion PictureAlignment::searched() const {
    float best = score_at(0, 0);
    Eigen::Vector2d shift = Eigen::Vector2d::Zero();  // px of the full picture
    for (int dy = -settings_.reach; dy <= settings_.reach; ++dy) {
        for (int dx = -settings_.reach; dx <= settings_.reach; ++dx) {
            const float score = score_at(dx, dy);
            if (score <= best) continue;
            best = score;
            shift = (factor_ << (levels - 1)) * Eigen::Vector2d(dx, dy);
        }
    }
    MotionMatrix information = inverse_variances().asDiagonal();
    PictureMotion gradient = PictureMotion::Zero();
    for (const Block& block : blocks_) {
        information += block.jacobian.transpose() * block.jacobian;
        gradient += block.jacobian.transpose() * shift;
    }
    return information.ldlt().solve(gradient);
}

const Alignment& PictureAlignment::align(LumaView picture) {
    if (!has_reference()) return found_;
    fill_pyramid(picture, &Level::picture);
    for (Block& block : blocks_) block.still = residual(0, block, PictureMotion::Zero()).variance;
    Alignment here;
    weigh(refined(found_.motion, 0), here);
    if (here.showing < settings_.found_above) {
        Alignment there;
        weigh(refined(searched(), levels - 1), there);
        if (there.nats > here.nats) here = there;
    }
    found_ = here;
    if (here.nats <= 0) found_.motion.setZero();  // where to begin the next time
    return found_;
}

}  // namespace roomfix
