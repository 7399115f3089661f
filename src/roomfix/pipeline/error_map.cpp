#include "roomfix/pipeline/error_map.hpp"

#include <cmath>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

/// Nothing where the camera does not see the floor.
std::optional<double> radius_at(const View& view, const Eigen::Vector2d& place, double reading_sigma) {
    const auto pixel = project_map_point(view, {place.x(), place.y(), 0});
    if (!pixel || !view.model.contains(*pixel)) return std::nullopt;
    const auto floor = pixel_to_plane(view, *pixel, 0);
    if (!floor) return std::nullopt;
    const auto by = plane_point_by_calibration(view, *floor, 0);
    if (!by) return std::nullopt;
    const Eigen::Matrix2d covariance = *by * by->transpose() + reading_sigma * reading_sigma * floor->by_pixel * floor->by_pixel.transpose();
    constexpr double within = 5.991;  // 95 % of the probability in the plane, in squared standard deviations
    return std::sqrt(within * Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance, Eigen::EigenvaluesOnly).eigenvalues()[1]);
}

}  // namespace

ErrorMap error_map(const View& view, const std::vector<Polyline>& walls, double farthest, double reading_sigma, std::size_t most) {
    ErrorMap map;
    const Eigen::Vector2d foot = view.position().head<2>();
    for (;; map.cell *= 1.4) {
        map.cells.clear();
        // Cells of all cameras lie on one grid where they are of one size.
        const double x0 = (std::floor((foot.x() - farthest) / map.cell) + 0.5) * map.cell, y0 = (std::floor((foot.y() - farthest) / map.cell) + 0.5) * map.cell;
        for (double y = y0; y < foot.y() + farthest; y += map.cell) {
            for (double x = x0; x < foot.x() + farthest; x += map.cell) {
                const Eigen::Vector2d place(x, y);
                if ((place - foot).norm() > farthest) continue;
                const auto radius = radius_at(view, place, reading_sigma);
                if (radius && !wall_between(walls, foot, place)) map.cells.push_back({place, *radius});
            }
        }
        if (map.cells.size() <= most) return map;
    }
}

}  // namespace roomfix
