#include "roomfix/ceiling/triangle_search.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {

void find_triangles(std::span<const Eigen::Vector2d> places, const TriangleShape& shape, std::vector<TriangleMatch>& matches) {
    const double hypotenuse = std::hypot(shape.a, shape.b);
    const auto misfit = [&](double length, double expected) { return std::abs(length - expected) / (shape.tolerance + shape.stretch * expected); };
    const int count = static_cast<int>(places.size());
    for (int i = 0; i < count; ++i) {
        for (int j = 0; j < count; ++j) {
            const Eigen::Vector2d leg_a = places[static_cast<std::size_t>(j)] - places[static_cast<std::size_t>(i)];
            const double error_a = misfit(leg_a.norm(), shape.a);
            if (i == j || error_a > 1) continue;
            for (int k = 0; k < count; ++k) {
                const Eigen::Vector2d leg_b = places[static_cast<std::size_t>(k)] - places[static_cast<std::size_t>(i)];
                if (leg_a.x() * leg_b.y() - leg_a.y() * leg_b.x() <= 0) continue;
                const double error = std::max({error_a, misfit(leg_b.norm(), shape.b), misfit((leg_b - leg_a).norm(), hypotenuse)});
                if (error <= 1) matches.push_back({{i, j, k}, error});
            }
        }
    }
}

}  // namespace roomfix
