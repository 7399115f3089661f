#include "roomfix/imaging/picture_alignment.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr int coarse_block = 8;  // px of the smallest picture

float squared(float value) { return value * value; }

}  // namespace

std::optional<Eigen::Vector2d> seen_after(const CameraModel& model, const Eigen::Vector2d& ray, const PictureMotion& motion) {
    const Eigen::Vector3d before(ray.x(), ray.y(), 1);
    const Eigen::Vector3d turn = motion.head<3>();
    const double angle = turn.norm();
    const Eigen::Vector3d after = angle > 0 ? Eigen::Vector3d(Eigen::AngleAxisd(-angle, turn / angle) * before) : before;
    const auto pixel = project(model, after);
    if (!pixel) return std::nullopt;
    const Eigen::Vector2d middle(model.cx, model.cy);
    return Eigen::Vector2d(middle + (1 + motion[3]) * (*pixel - middle));
}

PictureMotion PictureAlignment::inverse_variances() const {
    PictureMotion sigmas = PictureMotion::Constant(settings_.most_turned);
    sigmas[3] = settings_.most_grown;
    return sigmas.cwiseAbs2().cwiseInverse();
}

void PictureAlignment::shrink(LumaView picture, Logs& logs) {
    logs.width = picture.width / factor_;
    logs.height = picture.height / factor_;
    logs.values.resize(static_cast<std::size_t>(logs.width) * static_cast<std::size_t>(logs.height));
    sums_.resize(static_cast<std::size_t>(logs.width));
    const int share = 16 * 65536 / (factor_ * factor_);  // sixteenths of a grey level per level summed up, in parts of 65536
    float* to = logs.values.data();
    for (int y = 0; y < logs.height; ++y) {
        std::fill(sums_.begin(), sums_.end(), 0);
        for (int line = 0; line < factor_; ++line) {
            const std::uint8_t* from = picture.row(y * factor_ + line);
            for (int x = 0; x < logs.width; ++x) {
                for (int i = 0; i < factor_; ++i) sums_[static_cast<std::size_t>(x)] += from[x * factor_ + i];
            }
        }
        for (const int sum : sums_) *to++ = log_of_[static_cast<std::size_t>((static_cast<std::int64_t>(sum) * share) >> 16)];
    }
}

void PictureAlignment::shrink_more(const Logs& logs, Logs& smallest) {
    smallest.width = logs.width / shrink_again;
    smallest.height = logs.height / shrink_again;
    smallest.values.assign(static_cast<std::size_t>(smallest.width) * static_cast<std::size_t>(smallest.height), 0.0f);
    for (int y = 0; y < smallest.height * shrink_again; ++y) {
        float* to = smallest.values.data() + static_cast<std::ptrdiff_t>(y / shrink_again) * smallest.width;
        for (int x = 0; x < smallest.width * shrink_again; ++x) to[x / shrink_again] += *logs.at(x, y) / (shrink_again * shrink_again);
    }
}

void PictureAlignment::set_reference(LumaView reference) {
    factor_ = (reference.width + settings_.width - 1) / settings_.width;
    for (std::size_t i = 0; i < log_of_.size(); ++i) log_of_[i] = std::log(static_cast<float>(i) / 16 + settings_.dark);
    shrink(reference, reference_);
    shrink_more(reference_, smallest_reference_);
    slope_x_.assign(reference_.values.size(), 0.0f);
    slope_y_.assign(reference_.values.size(), 0.0f);
    for (int y = 1; y + 1 < reference_.height; ++y) {
        for (int x = 1; x + 1 < reference_.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(reference_.width) + static_cast<std::size_t>(x);
            slope_x_[i] = 0.5f * (reference_.values[i + 1] - reference_.values[i - 1]);
            slope_y_[i] = 0.5f * (*reference_.at(x, y + 1) - *reference_.at(x, y - 1));
        }
    }
    blocks_.clear();
    constexpr float count = block_size * block_size;
    for (int top = 1; top + block_size < reference_.height; top += block_size) {
        for (int left = 1; left + block_size < reference_.width; left += block_size) {
            Block block;
            block.x = left;
            block.y = top;
            Eigen::Vector2f mean = Eigen::Vector2f::Zero();
            float level = 0;
            for (int y = top; y < top + block_size; ++y) {
                for (int x = left; x < left + block_size; ++x) {
                    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(reference_.width) + static_cast<std::size_t>(x);
                    const Eigen::Vector2f slope(slope_x_[i], slope_y_[i]);
                    block.slopes += slope * slope.transpose();
                    mean += slope / count;
                    level += reference_.values[i] / count;
                }
            }
            block.slopes -= count * mean * mean.transpose();
            const float slope = block.slopes.trace() / count;
            if (slope < squared(settings_.least_slope)) continue;
            block.expected = squared(settings_.level_noise / std::exp(level)) + squared(settings_.colour_noise) + squared(settings_.blur) * slope;
            const double middle = 0.5 * (block_size - 1);
            block.middle = factor_ * (Eigen::Vector2d(left + middle, top + middle) + Eigen::Vector2d(0.5, 0.5)) - Eigen::Vector2d(0.5, 0.5);
            const auto ray = unproject(model_, block.middle);
            if (!ray) continue;
            block.ray = *ray;
            constexpr double step = 1e-5;
            for (int i = 0; i < motion_parameters; ++i) {
                const auto shift = shift_of(block, step * PictureMotion::Unit(i));
                block.jacobian.col(i) = shift ? Eigen::Vector2d(*shift / step) : Eigen::Vector2d::Zero();
            }
            blocks_.push_back(block);
        }
    }
    ratios_.resize(blocks_.size());
    found_ = {};
}

/// px of the small picture.
std::optional<Eigen::Vector2d> PictureAlignment::shift_of(const Block& block, const PictureMotion& motion) const {
    const auto pixel = seen_after(model_, block.ray, motion);
    if (!pixel) return std::nullopt;
    return Eigen::Vector2d((*pixel - block.middle) / factor_);
}

/// Variance of what is left between a block of the reference and the picture where the motion puts it, but for one brightness; negative if that is not
/// in the picture. `by_shift`: the sum of what is left times the slopes.
float PictureAlignment::residual(const Block& block, const PictureMotion& motion, Eigen::Vector2f* by_shift) const {
    constexpr float count = block_size * block_size;
    const auto shift = shift_of(block, motion);
    if (!shift) return -1;
    const double column = std::floor(shift->x()), line = std::floor(shift->y());
    const double x0 = block.x + column, y0 = block.y + line;
    if (!(x0 >= 0 && y0 >= 0 && x0 + block_size + 1 < picture_.width && y0 + block_size + 1 < picture_.height)) return -1;
    const float right = static_cast<float>(shift->x() - column), down = static_cast<float>(shift->y() - line);
    float sum = 0, squares = 0, sum_x = 0, sum_y = 0, mean_x = 0, mean_y = 0;
    for (int y = 0; y < block_size; ++y) {
        const float* above = picture_.at(static_cast<int>(x0), static_cast<int>(y0) + y);
        const float* below = above + picture_.width;
        const float* there = reference_.at(block.x, block.y + y);
        const std::ptrdiff_t at = there - reference_.values.data();
        const float* slope_x = slope_x_.data() + at;
        const float* slope_y = slope_y_.data() + at;
        for (int x = 0; x < block_size; ++x) {
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
    const float mean = sum / count;
    if (by_shift) *by_shift = Eigen::Vector2f(sum_x - mean * mean_x, sum_y - mean * mean_y);
    return std::max(squares / count - mean * mean, 0.0f);
}

/// Gauss-Newton, in which what shows something else weighs less and less.
PictureMotion PictureAlignment::refined(PictureMotion motion) {
    constexpr int steps = 8;
    constexpr float count = block_size * block_size;
    for (int step = 0; step < steps; ++step) {
        const float blur = std::max(settings_.blur, 1.0f - 0.2f * static_cast<float>(step));  // px that the motion may still be off
        Eigen::Matrix<double, motion_parameters, motion_parameters> information = inverse_variances().asDiagonal();
        PictureMotion gradient = inverse_variances().cwiseProduct(motion);
        for (const Block& block : blocks_) {
            Eigen::Vector2f by_shift;
            const float left = residual(block, motion, &by_shift);
            if (left < 0) continue;
            const float expected = block.expected + (squared(blur) - squared(settings_.blur)) * block.slopes.trace() / count;
            const float weight = 1 / squared(1 + std::max(left / expected - 1, 0.0f) / settings_.alike) / expected / settings_.same_noise;
            information += block.jacobian.transpose() * (weight * block.slopes).cast<double>() * block.jacobian;
            gradient += block.jacobian.transpose() * (weight * by_shift).cast<double>();
        }
        const PictureMotion change = information.ldlt().solve(gradient);
        motion -= change;
        if (!motion.allFinite()) return PictureMotion::Zero();
        if (blur <= settings_.blur && offset_of(change) < 0.02 * factor_) break;
    }
    return motion;
}

/// px of the full picture, root mean square over the blocks.
double PictureAlignment::offset_of(const PictureMotion& motion) const {
    double sum = 0;
    for (const Block& block : blocks_) sum += (block.jacobian * motion).squaredNorm();
    return factor_ * std::sqrt(sum / static_cast<double>(std::max<std::size_t>(blocks_.size(), 1)));
}

void PictureAlignment::weigh(const PictureMotion& motion, Alignment& found) {
    found.motion = motion;
    found.offset = offset_of(motion);
    std::size_t seen = 0;
    for (Block& block : blocks_) {
        block.still = residual(block, PictureMotion::Zero(), nullptr);
        block.left = residual(block, motion, nullptr);
        if (block.left >= 0) ratios_[seen++] = block.left / block.expected;
    }
    if (seen < blocks_.size() / 4 + 1) {  // it would show hardly anything of the reference
        found.nats = -1e9;
        found.showing = 0;
        return;
    }
    // Pictures that are noisier than expected (much compressed, out of focus) are so everywhere.
    const auto quarter = ratios_.begin() + static_cast<std::ptrdiff_t>(seen / 4);
    std::nth_element(ratios_.begin(), quarter, ratios_.begin() + static_cast<std::ptrdiff_t>(seen));
    const float noisier = std::clamp(*quarter, 1.0f, 10.0f);
    const float independent = block_size * block_size / settings_.same_noise;
    std::size_t showing = 0;
    found.nats = 0;
    for (const Block& block : blocks_) {
        if (block.left < 0 || block.still < 0) continue;
        const float expected = noisier * block.expected;
        showing += block.left < settings_.alike * expected;
        const float nats = 0.5f * independent * std::log(std::max(block.still, expected) / std::max(block.left, expected));
        found.nats += static_cast<double>(std::clamp(nats, -settings_.most_nats, settings_.most_nats));
    }
    found.showing = static_cast<double>(showing) / static_cast<double>(seen);
}

/// How well the smallest picture, shifted, shows the reference, nats.
float PictureAlignment::score_at(int dx, int dy) const {
    constexpr float count = coarse_block * coarse_block;
    const float most = settings_.most_nats;
    float score = 0;
    for (int top = 0; top + coarse_block <= smallest_.height; top += coarse_block) {
        for (int left = 0; left + coarse_block <= smallest_.width; left += coarse_block) {
            if (left + dx < 0 || top + dy < 0 || left + dx + coarse_block > smallest_.width || top + dy + coarse_block > smallest_.height) continue;
            float sum = 0, squares = 0, level = 0, levels = 0;
            for (int y = top; y < top + coarse_block; ++y) {
                const float* there = smallest_reference_.at(left, y);
                const float* here = smallest_.at(left + dx, y + dy);
                for (int x = 0; x < coarse_block; ++x) {
                    const float difference = here[x] - there[x];
                    sum += difference;
                    squares += difference * difference;
                    level += there[x];
                    levels += there[x] * there[x];
                }
            }
            const float left_over = squares / count - squared(sum / count), structure = levels / count - squared(level / count);
            const float floor = squared(settings_.least_slope);
            score += std::clamp(0.5f * count / settings_.same_noise * std::log((structure + floor) / (left_over + floor)), -most, most);
        }
    }
    return score;
}

/// The shift of the whole picture at which it shows the reference best, as a motion.
PictureMotion PictureAlignment::searched() const {
    float best = score_at(0, 0);
    Eigen::Vector2d shift = Eigen::Vector2d::Zero();
    for (int dy = -settings_.reach; dy <= settings_.reach; ++dy) {
        for (int dx = -settings_.reach; dx <= settings_.reach; ++dx) {
            const float score = score_at(dx, dy);
            if (score <= best) continue;
            best = score;
            shift = shrink_again * Eigen::Vector2d(dx, dy);
        }
    }
    Eigen::Matrix<double, motion_parameters, motion_parameters> information = inverse_variances().asDiagonal();
    PictureMotion gradient = PictureMotion::Zero();
    for (const Block& block : blocks_) {
        information += block.jacobian.transpose() * block.jacobian;
        gradient += block.jacobian.transpose() * shift;
    }
    return information.ldlt().solve(gradient);
}

const Alignment& PictureAlignment::align(LumaView picture) {
    if (!has_reference()) return found_;
    shrink(picture, picture_);
    Alignment here;
    weigh(refined(found_.motion), here);
    if (here.showing < settings_.lost_below) {
        shrink_more(picture_, smallest_);
        Alignment there;
        weigh(refined(searched()), there);
        if (there.nats > here.nats) here = there;
    }
    found_ = here;
    if (here.nats <= 0) found_.motion.setZero();  // where to begin the next time
    return found_;
}

}  // namespace roomfix
