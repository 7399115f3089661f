#include "roomfix/calibrate/prism.hpp"

#include <algorithm>

#include "roomfix/geometry/convex_hull.hpp"

namespace roomfix {

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
