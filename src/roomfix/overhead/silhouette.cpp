#include "roomfix/overhead/silhouette.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/geometry/convex_hull.hpp"

namespace roomfix {

ShapePoints shape_points(const Shape& shape, double size_sigma) {
    ShapePoints result;
    result.size_sigma = size_sigma;
    const Eigen::Vector3d half = half_size(shape);
    result.height = 2 * half.z();
    if (const auto* box = std::get_if<Box>(&shape)) {
        for (int i = 0; i < 8; ++i) {
            result.points[static_cast<std::size_t>(result.count++)] = {i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? result.height : 0};
        }
        const bool square = std::abs(box->length - box->width) < 0.01 * std::max(box->length, box->width);
        result.symmetry = square ? std::numbers::pi / 2 : std::numbers::pi;
        result.radius = half.head<2>().norm();
        return result;
    }
    constexpr int rim = 32;
    for (int i = 0; i < 2 * rim; ++i) {
        const double angle = 2 * std::numbers::pi * (i % rim) / rim;
        // Corners a little outside the circle, so that the polygon has the circle's mean radius.
        const double r = half.x() / (1 - 0.25 * std::pow(std::numbers::pi / rim, 2));
        result.points[static_cast<std::size_t>(result.count++)] = {r * std::cos(angle), r * std::sin(angle), i < rim ? 0 : result.height};
    }
    result.radius = half.x();
    return result;
}

Eigen::Vector3d pose_difference(const Pose2& a, const Pose2& b, const ShapePoints& shape) {
    return {b.x - a.x, b.y - a.y, shape.round() ? 0 : std::remainder(b.yaw - a.yaw, shape.symmetry)};
}

Eigen::Vector3d body_point_map(const ShapePoints& shape, int index, const Pose2& pose) {
    const Eigen::Vector3d& p = shape.points[static_cast<std::size_t>(index)];
    const double c = std::cos(pose.yaw);
    const double s = std::sin(pose.yaw);
    return {pose.x + c * p.x() - s * p.y(), pose.y + s * p.x() + c * p.y(), p.z()};
}

Silhouette project_silhouette(const View& view, const ShapePoints& shape, const Pose2& pose) {
    Silhouette silhouette;
    std::array<Eigen::Vector2d, ShapePoints::capacity> pixels;
    const Eigen::Matrix3d camera_from_map = view.map_from_camera.pose.linear().transpose();
    const double c = std::cos(pose.yaw);
    const double s = std::sin(pose.yaw);
    for (int i = 0; i < shape.count; ++i) {
        const Eigen::Vector3d& p = shape.points[static_cast<std::size_t>(i)];
        const Eigen::Vector3d map(pose.x + c * p.x() - s * p.y(), pose.y + s * p.x() + c * p.y(), p.z());
        const auto pixel = project(view.model, camera_from_map * (map - view.position()));
        if (!pixel) return silhouette;
        pixels[static_cast<std::size_t>(i)] = *pixel;
    }
    std::array<int, ShapePoints::capacity + 1> order;
    silhouette.count = convex_hull({pixels.data(), static_cast<std::size_t>(shape.count)}, order, silhouette.indices);
    for (int i = 0; i < silhouette.count; ++i) {
        silhouette.corners[static_cast<std::size_t>(i)] = pixels[static_cast<std::size_t>(silhouette.indices[static_cast<std::size_t>(i)])];
    }
    return silhouette;
}

PixelBox box_around(std::span<const Eigen::Vector2d> polygon) {
    PixelBox box{Eigen::Vector2d::Constant(1e9), Eigen::Vector2d::Constant(-1e9)};
    for (const auto& p : polygon) {
        box.low = box.low.cwiseMin(p);
        box.high = box.high.cwiseMax(p);
    }
    return box;
}

double polygon_area(std::span<const Eigen::Vector2d> polygon) {
    double twice = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto& p = polygon[i];
        const auto& q = polygon[(i + 1) % polygon.size()];
        twice += p.x() * q.y() - q.x() * p.y();
    }
    return std::abs(twice) / 2;
}

Eigen::Vector2d polygon_centroid(std::span<const Eigen::Vector2d> polygon) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weight = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Eigen::Vector2d p = polygon[i] - polygon[0];
        const Eigen::Vector2d q = polygon[(i + 1) % polygon.size()] - polygon[0];
        const double cross = p.x() * q.y() - q.x() * p.y();
        sum += cross * (p + q) / 3;
        weight += cross;
    }
    return std::abs(weight) > 1e-12 ? Eigen::Vector2d(polygon[0] + sum / weight) : polygon[0];
}

bool inside_polygon(std::span<const Eigen::Vector2d> polygon, const Eigen::Vector2d& point, double margin) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Eigen::Vector2d edge = polygon[(i + 1) % polygon.size()] - polygon[i];
        const Eigen::Vector2d to = point - polygon[i];
        const double length = edge.norm();
        if (length > 0 && edge.x() * to.y() - edge.y() * to.x() < -margin * length) return false;
    }
    return true;
}

bool inside_any(std::span<const Silhouette> silhouettes, const Eigen::Vector2d& point, double margin) {
    return std::any_of(silhouettes.begin(), silhouettes.end(),
                       [&](const Silhouette& one) { return one.valid() && inside_polygon(one.polygon(), point, margin); });
}

RegionCount count_region(const BitMask& foreground, const BitMask& shadow, const BitMask* taken, std::span<const Eigen::Vector2d> polygon, int step) {
    int area = 0;
    int inside = 0;
    int dark = 0;
    int others = 0;
    for_polygon_rows(polygon, foreground.width(), foreground.height(), step, [&](int y, int begin, int end) {
        area += end - begin;
        inside += foreground.count_run(y, begin, end);
        dark += shadow.count_run(y, begin, end);
        if (taken) others += taken->count_run(y, begin, end);
    });
    const double scale = step;
    return {area * scale, inside * scale, dark * scale, others * scale};
}

void clear_region(BitMask& mask, std::span<const Eigen::Vector2d> polygon) {
    for_polygon_rows(polygon, mask.width(), mask.height(), 1, [&](int y, int begin, int end) { mask.clear_run(y, begin, end); });
}

void fill_region(BitMask& mask, std::span<const Eigen::Vector2d> polygon) {
    for_polygon_rows(polygon, mask.width(), mask.height(), 1, [&](int y, int begin, int end) { mask.set_run(y, begin, end); });
}

}  // namespace roomfix
