#include "roomfix/corner/outside_corner.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace roomfix {

CornerCompanions companions_of(const CornerView& view, double wall_angle, const std::vector<SceneLine>& lines, const CameraModel& model,
                               const OutsideCornerSettings& settings) {
    CornerCompanions companions;
    const auto rays = corner_rays(view, wall_angle);
    if (!rays) return companions;
    const Eigen::Vector3d sight = rays->corner.homogeneous().normalized();
    std::array<Eigen::Vector3d, 3> inside = edge_directions(wall_angle);
    std::array<Eigen::Vector3d, 3> outside;
    for (std::size_t i = 0; i < 3; ++i) {
        inside[i] = view.corner_from_camera.transpose() * inside[i];
        outside[i] = inside[i] - 2 * inside[i].dot(sight) * sight;
    }
    const double focal = 0.5 * (model.fx + model.fy);
    for (const SceneLine& line : lines) {
        const auto ends = line.ends();
        const double length = (ends[1] - ends[0]).norm() * focal;
        if (length < settings.least_length * length_unit(model) || line.density < settings.density) continue;
        const Eigen::Vector3d normal = ends[0].homogeneous().cross(ends[1].homogeneous()).normalized();
        const auto off = [&](const Eigen::Vector3d& direction) { return std::abs(normal.dot(direction)); };
        const auto least_off = [&](const std::array<Eigen::Vector3d, 3>& directions) {
            return std::min({off(directions[0]), off(directions[1]), off(directions[2])});
        };
        if (off(sight) < settings.near_corner) continue;
        const double off_inside = std::max(least_off(inside), settings.end_error / length);
        const double off_outside = std::max(least_off(outside), settings.end_error / length);
        if (off_inside < settings.tolerance && off_outside > settings.clearly * off_inside) companions.inside += length;
        if (off_outside < settings.tolerance && off_inside > settings.clearly * off_outside) companions.outside += length;
    }
    return companions;
}

}  // namespace roomfix
