#include "roomfix/overhead/outline_search.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr std::uint16_t far_away = 60000;
constexpr double sample_spacing = 4;  // px along the outline
constexpr double near_border = 3.5;   // px: closer counts as support, the closer the more

}  // namespace

void BorderDistance::compute(const BitMask& mask, int left, int top, int right, int bottom, int margin) {
    left_ = std::max(left - margin, 0);
    top_ = std::max(top - margin, 0);
    width_ = std::min(right + margin, mask.width() - 1) - left_ + 1;
    height_ = std::min(bottom + margin, mask.height() - 1) - top_ + 1;
    thirds_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), far_away);
    const auto index = [&](int x, int y) { return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x); };
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            const int u = left_ + x;
            const int v = top_ + y;
            if (!mask.at(u, v)) continue;
            const bool edge = (u > 0 && !mask.at(u - 1, v)) || (u + 1 < mask.width() && !mask.at(u + 1, v)) ||
                              (v > 0 && !mask.at(u, v - 1)) || (v + 1 < mask.height() && !mask.at(u, v + 1));
            if (edge) thirds_[index(x, y)] = 0;
        }
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

namespace {

double outline_support(const BorderDistance& border, const Silhouette& silhouette) {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < silhouette.count; ++i) {
        const Eigen::Vector2d from = silhouette.corners[static_cast<std::size_t>(i)];
        const Eigen::Vector2d side = silhouette.corners[static_cast<std::size_t>((i + 1) % silhouette.count)] - from;
        const int samples = std::max(1, static_cast<int>(side.norm() / sample_spacing));
        for (int k = 0; k < samples; ++k) {
            const double distance = static_cast<double>(border.at(from + side * ((k + 0.5) / samples)));
            sum += std::max(0.0, 1 - distance / near_border);
            ++count;
        }
    }
    return count > 0 ? sum / count : 0;
}

}  // namespace

void search_outline(const BorderDistance& border, const View& view, const ShapePoints& shape, const std::vector<CoarsePose>& around,
                    std::size_t most, std::vector<OutlineStart>& found) {
    found.clear();
    const double step = 0.12 * shape.radius;
    constexpr int reach = 4;  // steps to each side
    const int turns = shape.round() ? 1 : static_cast<int>(std::lround(shape.symmetry / 0.13));
    for (const CoarsePose& centre : around) {
        for (int j = -reach; j <= reach; ++j) {
            for (int i = -reach; i <= reach; ++i) {
                for (int turn = 0; turn < turns; ++turn) {
                    const Pose2 pose{centre.pose.x + i * step, centre.pose.y + j * step, shape.symmetry * turn / turns};
                    const Silhouette silhouette = project_silhouette(view, shape, pose);
                    if (silhouette.valid()) found.push_back({pose, outline_support(border, silhouette)});
                }
            }
        }
    }
    std::sort(found.begin(), found.end(), [](const OutlineStart& a, const OutlineStart& b) { return a.support > b.support; });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < found.size() && kept < most; ++i) {
        const bool apart = std::none_of(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(kept), [&](const OutlineStart& k) {
            const double turned = shape.round() ? 0 : std::abs(std::remainder(k.pose.yaw - found[i].pose.yaw, shape.symmetry));
            return std::hypot(k.pose.x - found[i].pose.x, k.pose.y - found[i].pose.y) < 2.1 * step && turned < 0.2;
        });
        if (apart) found[kept++] = found[i];
    }
    found.resize(kept);
}

}  // namespace roomfix
