#include "roomfix/corner/corner_geometry.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace roomfix {

std::array<Eigen::Vector3d, 3> edge_directions(double wall_angle) {
    return {Eigen::Vector3d::UnitX(), Eigen::Vector3d(std::cos(wall_angle), std::sin(wall_angle), 0), -Eigen::Vector3d::UnitZ()};
}

std::optional<CornerRays> corner_rays(const CornerView& view, double wall_angle) {
    const Eigen::Matrix3d camera_from_corner = view.corner_from_camera.transpose();
    const Eigen::Vector3d corner = camera_from_corner * Eigen::Vector3d(-view.place.x(), -view.place.y(), 1);
    if (!(corner.z() > 1e-9)) return std::nullopt;
    CornerRays rays;
    rays.corner = corner.head<2>() / corner.z();
    const auto edges = edge_directions(wall_angle);
    for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector3d along = camera_from_corner * edges[i];
        const Eigen::Vector2d moves = along.head<2>() - rays.corner * along.z();
        const double length = moves.norm();
        if (!(length > 1e-12)) return std::nullopt;
        rays.directions[i] = moves / length;
    }
    return rays;
}

std::optional<Eigen::Vector2d> corner_pixel(const CameraModel& model, const CornerView& view, double wall_angle) {
    const auto rays = corner_rays(view, wall_angle);
    if (!rays) return std::nullopt;
    return project(model, rays->corner.homogeneous());
}

bool is_inside(const CornerView& view, double wall_angle) {
    // place = a (1, 0) + b (cos, sin) with a, b > 0
    const double b = view.place.y() / std::sin(wall_angle);
    return b > 0 && view.place.x() - b * std::cos(wall_angle) > 0;
}

namespace {

/// Edge i runs from the corner along -k_i c + u_i: c is the ray to the corner, u_i the line's direction seen along that ray. k_i says how
/// steeply the edge comes towards the camera. Then k_i k_j = cos(angle between the edges) sqrt(..) - u_i . u_j.
std::optional<CornerView> view_from_slopes(const Eigen::Vector3d& ray, const std::array<Eigen::Vector3d, 3>& u, const std::array<double, 3>& k,
                                           double wall_angle) {
    const Eigen::Vector3d along_x = (u[x_edge] - k[x_edge] * ray).normalized();
    const Eigen::Vector3d up = -(u[wall_edge] - k[wall_edge] * ray).normalized();
    CornerView view;
    view.corner_from_camera.row(2) = up;
    view.corner_from_camera.row(1) = up.cross(along_x).normalized();
    view.corner_from_camera.row(0) = view.corner_from_camera.row(1).cross(view.corner_from_camera.row(2));
    const Eigen::Vector3d to_corner = view.corner_from_camera * ray;
    if (!(to_corner.z() > 1e-9)) return std::nullopt;
    view.place = -to_corner.head<2>() / to_corner.z();
    // The y edge must lie on its own side: with the lines in the wrong order it would come out mirrored.
    const Eigen::Vector3d along_y = view.corner_from_camera * (u[y_edge] - k[y_edge] * ray);
    if (along_y.y() <= 0 || !is_inside(view, wall_angle)) return std::nullopt;
    return view;
}

}  // namespace

CornerSolutions solve_corner(const CornerRays& rays, double wall_angle) {
    CornerSolutions solutions;
    const Eigen::Vector3d ray = rays.corner.homogeneous().normalized();
    std::array<Eigen::Vector3d, 3> u;
    for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector3d along(rays.directions[i].x(), rays.directions[i].y(), 0);
        u[i] = (along - along.dot(ray) * ray).normalized();
    }
    // The walls' edge stands upright on both others: k_x k_w = a, k_y k_w = b. With q = 1 / k_w^2 the angle between the walls gives
    // a b q + c = cos(wall_angle) sqrt((1 + a^2 q) (1 + b^2 q)).
    const double a = -u[x_edge].dot(u[wall_edge]);
    const double b = -u[y_edge].dot(u[wall_edge]);
    const double c = u[x_edge].dot(u[y_edge]);
    const double cosine = std::abs(wall_angle - std::numbers::pi / 2) < 1e-12 ? 0.0 : std::cos(wall_angle);
    std::array<double, 2> roots{};
    int count = 0;
    if (cosine == 0) {
        roots[0] = -c / (a * b);
        count = 1;
    } else {
        const double square = cosine * cosine;
        const double p = a * a * b * b * (1 - square);
        const double half_q = 0.5 * (2 * a * b * c - square * (a * a + b * b));
        const double r = c * c - square;
        const double discriminant = half_q * half_q - p * r;
        if (discriminant < 0) return solutions;
        const double stable = -(half_q + std::copysign(std::sqrt(discriminant), half_q));
        roots = {stable / p, r / stable};
        count = 2;
    }
    for (int i = 0; i < count; ++i) {
        const double q = roots[static_cast<std::size_t>(i)];
        if (!(q > 0) || !std::isfinite(q)) continue;
        const double side = a * b * q + c;
        if (cosine != 0 && side * cosine < 0) continue;
        const double k_w = 1 / std::sqrt(q);
        if (const auto view = view_from_slopes(ray, u, {a / k_w, b / k_w, k_w}, wall_angle))
            solutions.views[static_cast<std::size_t>(solutions.count++)] = *view;
    }
    return solutions;
}

std::array<CornerRays, 3> labellings(const CornerRays& rays) {
    std::array<CornerRays, 3> all;
    for (std::size_t wall = 0; wall < 3; ++wall) {
        std::size_t first = (wall + 1) % 3;
        std::size_t second = (wall + 2) % 3;
        // Seen from inside the room and from below, the edges x, y, down follow each other clockwise in the picture (y points down).
        const auto turn = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) { return p.x() * q.y() - p.y() * q.x(); };
        const double to_first = std::atan2(turn(rays.directions[wall], rays.directions[first]), rays.directions[wall].dot(rays.directions[first]));
        const double to_second = std::atan2(turn(rays.directions[wall], rays.directions[second]), rays.directions[wall].dot(rays.directions[second]));
        const auto positive = [](double angle) { return angle < 0 ? angle + 2 * std::numbers::pi : angle; };
        if (positive(to_first) > positive(to_second)) std::swap(first, second);
        all[wall].corner = rays.corner;
        all[wall].directions = {rays.directions[first], rays.directions[second], rays.directions[wall]};
    }
    return all;
}

}  // namespace roomfix
