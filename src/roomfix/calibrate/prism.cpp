#include "roomfix/calibrate/prism.hpp"

#include <algorithm>

#include "roomfix/geometry/convex_hull.hpp"

namespace roomfix {

std::vector<Eigen::Vector2d> hull_of(const std::vector<Eigen::Vector2d>& points) {
    std::vector<int> order(points.size() + 1);
    std::vector<int> hull(points.size() + 1);
    const int corners = convex_hull(points, order, hull);
    std::vector<Eigen::Vector2d> result;
    for (int i = 0; i < corners; ++i) result.push_back(points[static_cast<std::size_t>(hull[static_cast<std::size_t>(i)])]);
    return result;
}

Prism prism_of(const ConvexPart& part) {
    Prism prism;
    std::vector<Eigen::Vector2d> points;
    for (const Eigen::Vector3d& p : part.points) {
        points.push_back(p.head<2>());
        prism.low = std::min(prism.low, p.z());
        prism.high = std::max(prism.high, p.z());
    }
    prism.hull = hull_of(points);
    return prism;
}

}  // namespace roomfix
