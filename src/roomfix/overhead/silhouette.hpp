// The outline of a robot in a picture: its shape's points projected, and their convex hull.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/bit_mask.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// A convex body standing on the floor, as the points that span it (robot frame, m).
struct ShapePoints {
    static constexpr int capacity = 64;
    std::array<Eigen::Vector3d, capacity> points;
    int count = 0;
    double height = 0;
    double radius = 0;    // of the smallest circle around it on the floor
    double symmetry = 0;  // rad after which it looks the same; 0: it has no direction
    double size_sigma = 0.005;

    bool round() const { return symmetry == 0; }
};

/// A box by its corners, a cylinder by 32 points on each rim. A box whose length and width differ by less than one part in
/// a hundred looks the same after a quarter turn, any other after half a turn.
ShapePoints shape_points(const Shape& shape, double size_sigma);

/// The outline of a body at a pose: convex polygon in the image, and which of the body's points its corners are.
struct Silhouette {
    std::array<Eigen::Vector2d, ShapePoints::capacity> corners;  // px, interior on the right-hand side on the screen
    std::array<int, ShapePoints::capacity + 1> indices{};
    int count = 0;  // 0: the body is (partly) behind the camera or outside the lens model

    bool valid() const { return count >= 3; }
    std::span<const Eigen::Vector2d> polygon() const { return {corners.data(), static_cast<std::size_t>(count)}; }
};

/// The smallest upright rectangle around an outline, px.
struct PixelBox {
    Eigen::Vector2d low, high;
};
PixelBox box_around(std::span<const Eigen::Vector2d> polygon);

/// Pose b less pose a: m, m, rad; the yaw modulo the shape's symmetry, 0 for round ones.
Eigen::Vector3d pose_difference(const Pose2& a, const Pose2& b, const ShapePoints& shape);

/// A point of the body in the map.
Eigen::Vector3d body_point_map(const ShapePoints& shape, int index, const Pose2& pose);

Silhouette project_silhouette(const View& view, const ShapePoints& shape, const Pose2& pose);

/// Twice the signed area over two, px^2.
double polygon_area(std::span<const Eigen::Vector2d> polygon);
Eigen::Vector2d polygon_centroid(std::span<const Eigen::Vector2d> polygon);
/// True if the point is inside the convex polygon grown by `margin` px.
bool inside_polygon(std::span<const Eigen::Vector2d> polygon, const Eigen::Vector2d& point, double margin);

/// How much of a polygon is what. Every `step`-th row is looked at and counts `step` times.
struct RegionCount {
    double area = 0;        // px inside the image
    double foreground = 0;  // of these, foreground
    double shadow = 0;      // of the foreground, perhaps only shadow
    double taken = 0;       // already explained by other robots: says nothing
};
/// `taken` may be null.
RegionCount count_region(const BitMask& foreground, const BitMask& shadow, const BitMask* taken, std::span<const Eigen::Vector2d> polygon, int step);

/// Clears the polygon's pixels in a mask.
void clear_region(BitMask& mask, std::span<const Eigen::Vector2d> polygon);
/// Sets them.
void fill_region(BitMask& mask, std::span<const Eigen::Vector2d> polygon);

}  // namespace roomfix
