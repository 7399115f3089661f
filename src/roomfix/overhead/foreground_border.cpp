#include "roomfix/overhead/foreground_border.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr std::uint16_t far_away = 60000;
constexpr double outline_width = 2.5;    // px: a border pixel so near to the outline lies on it
constexpr float step_of_border = 0.12f;  // part of the light: a step in the empty room that may be something's border

/// The largest step of the background across a place, near it: levels two and three pixels to both sides, as a part of the
/// lighter one.
float step_across(LumaView background, const Eigen::Vector2f& place, const Eigen::Vector2f& normal) {
    const auto level = [&](float s) {
        const Eigen::Vector2f p = place + s * normal;
        return sample(background, std::clamp(p.x(), 1.0f, static_cast<float>(background.width - 3)),
                      std::clamp(p.y(), 1.0f, static_cast<float>(background.height - 3)));
    };
    float largest = 0;
    for (float shift = -2; shift <= 2; ++shift) {
        const float a = level(shift + 2) + level(shift + 3);
        const float b = level(shift - 2) + level(shift - 3);
        largest = std::max(largest, std::abs(a - b) / std::max({a, b, 40.0f}));
    }
    return largest;
}

double distance_to(std::span<const Eigen::Vector2d> polygon, const Eigen::Vector2d& point) {
    double best = 1e18;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Eigen::Vector2d side = polygon[(i + 1) % polygon.size()] - polygon[i];
        const double along = std::clamp((point - polygon[i]).dot(side) / std::max(side.squaredNorm(), 1e-9), 0.0, 1.0);
        best = std::min(best, (polygon[i] + along * side - point).squaredNorm());
    }
    return std::sqrt(best);
}

}  // namespace

void ForegroundBorder::compute(const BitMask& mask, const BitMask& shadow, LumaView background, int left, int top, int right, int bottom) {
    pixels_.clear();
    left = std::max(left, 3);
    top = std::max(top, 3);
    right = std::min(right, mask.width() - 4);
    bottom = std::min(bottom, mask.height() - 4);
    for (int y = top; y <= bottom; ++y) {
        for (int x = left; x <= right; ++x) {
            if (!mask.at(x, y) || (mask.at(x - 1, y) && mask.at(x + 1, y) && mask.at(x, y - 1) && mask.at(x, y + 1))) continue;
            Eigen::Vector2f outwards = Eigen::Vector2f::Zero();
            for (int dy = -2; dy <= 2; ++dy) {
                for (int dx = -2; dx <= 2; ++dx) {
                    if (!mask.at(x + dx, y + dy)) outwards += Eigen::Vector2f(static_cast<float>(dx), static_cast<float>(dy));
                }
            }
            const Eigen::Vector2f normal = outwards.norm() > 0.5f ? Eigen::Vector2f(outwards.normalized()) : Eigen::Vector2f::UnitX();
            Pixel pixel;
            pixel.place = {static_cast<float>(x), static_cast<float>(y)};
            pixel.on_background_edge = step_across(background, pixel.place, normal) > step_of_border;
            int dark = 0;
            for (float s = 1; s <= 3; ++s) {
                const Eigen::Vector2f inside = pixel.place - s * normal;
                dark += shadow.at(static_cast<int>(std::lround(inside.x())), static_cast<int>(std::lround(inside.y())));
            }
            pixel.of_shadow = dark >= 2;
            pixels_.push_back(pixel);
        }
    }
}

double ForegroundBorder::unexplained(const Silhouette& silhouette) const {
    if (pixels_.empty()) return 0;
    int count = 0;
    for (const Pixel& pixel : pixels_) {
        if (pixel.on_background_edge) continue;
        const Eigen::Vector2d place = pixel.place.cast<double>();
        if (pixel.of_shadow && !inside_polygon(silhouette.polygon(), place, 0)) continue;
        count += distance_to(silhouette.polygon(), place) > outline_width;
    }
    return static_cast<double>(count) / static_cast<double>(pixels_.size());
}

void BorderDistance::compute(const ForegroundBorder& border, int width, int height, int left, int top, int right, int bottom, int margin) {
    left_ = std::max(left - margin, 0);
    top_ = std::max(top - margin, 0);
    width_ = std::min(right + margin, width - 1) - left_ + 1;
    height_ = std::min(bottom + margin, height - 1) - top_ + 1;
    thirds_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), far_away);
    const auto index = [&](int x, int y) { return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x); };
    for (const ForegroundBorder::Pixel& pixel : border.pixels()) {
        const int x = static_cast<int>(pixel.place.x()) - left_;
        const int y = static_cast<int>(pixel.place.y()) - top_;
        if (!pixel.on_background_edge && x >= 0 && y >= 0 && x < width_ && y < height_) thirds_[index(x, y)] = 0;
    }
    const auto relax = [&](int x, int y, int dx, int dy, int cost) {
        if (x + dx < 0 || x + dx >= width_ || y + dy < 0 || y + dy >= height_) return;
        auto& here = thirds_[index(x, y)];
        here = static_cast<std::uint16_t>(std::min<int>(here, thirds_[index(x + dx, y + dy)] + cost));
    };
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            relax(x, y, -1, 0, 3);
            relax(x, y, 0, -1, 3);
            relax(x, y, -1, -1, 4);
            relax(x, y, 1, -1, 4);
        }
    }
    for (int y = height_ - 1; y >= 0; --y) {
        for (int x = width_ - 1; x >= 0; --x) {
            relax(x, y, 1, 0, 3);
            relax(x, y, 0, 1, 3);
            relax(x, y, 1, 1, 4);
            relax(x, y, -1, 1, 4);
        }
    }
}

float BorderDistance::at(const Eigen::Vector2d& pixel) const {
    const int x = static_cast<int>(std::lround(pixel.x())) - left_;
    const int y = static_cast<int>(std::lround(pixel.y())) - top_;
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return 1e4f;
    return static_cast<float>(thirds_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)]) / 3.0f;
}

}  // namespace roomfix
