#include "roomfix/overhead/outline_search.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/overhead/keep_apart.hpp"

namespace roomfix {
namespace {

constexpr double sample_spacing = 4;  // px along the outline
constexpr double near_border = 3.5;   // px: closer counts as support, the closer the more; at least half a step of the search
constexpr double place_step = 0.2;    // of the body's radius
constexpr double turn_step = 0.2;     // rad

double outline_support(const BorderDistance& border, const Silhouette& silhouette, double near) {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < silhouette.count; ++i) {
        const Eigen::Vector2d from = silhouette.corners[static_cast<std::size_t>(i)];
        const Eigen::Vector2d side = silhouette.corners[static_cast<std::size_t>((i + 1) % silhouette.count)] - from;
        const int samples = std::max(1, static_cast<int>(side.norm() / sample_spacing));
        for (int k = 0; k < samples; ++k) {
            const double distance = static_cast<double>(border.at(from + side * ((k + 0.5) / samples)));
            sum += std::max(0.0, 1 - distance / near);
            ++count;
        }
    }
    return count > 0 ? sum / count : 0;
}

}  // namespace

void search_outline(const BorderDistance& border, const View& view, const ShapePoints& shape, const FloorRectangle& floor, std::size_t most,
                    std::vector<OutlineStart>& found) {
    found.clear();
    const double step = place_step * shape.radius;
    const int turns = shape.round() ? 1 : static_cast<int>(std::lround(shape.symmetry / turn_step));
    for (double y = floor.low.y(); y <= floor.high.y(); y += step) {
        for (double x = floor.low.x(); x <= floor.high.x(); x += step) {
            for (int turn = 0; turn < turns; ++turn) {
                const Pose2 pose{x, y, shape.symmetry * turn / turns};
                const Silhouette silhouette = project_silhouette(view, shape, pose);
                if (!silhouette.valid()) continue;
                const double size = std::sqrt(polygon_area(silhouette.polygon()));
                found.push_back({pose, outline_support(border, silhouette, std::max(near_border, 0.25 * place_step * size))});
            }
        }
    }
    std::sort(found.begin(), found.end(), [](const OutlineStart& a, const OutlineStart& b) { return a.support > b.support; });
    keep_apart(found, most, [&](const OutlineStart& a, const OutlineStart& b) {
        const Eigen::Vector3d off = pose_difference(a.pose, b.pose, shape);
        return off.head<2>().norm() < 1.1 * step && std::abs(off.z()) < 1.1 * turn_step;
    });
}

}  // namespace roomfix
