// The outline of a robot in a picture: its shape's points projected, and their convex hull.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
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
/// The same of any of some outlines.
bool inside_any(std::span<const Silhouette> silhouettes, const Eigen::Vector2d& point, double margin);

/// Calls visit(y, begin, end) for the pixels begin <= x < end whose centres are inside the convex polygon, in rows that are multiples of `step`.
template <class Visit>
void for_polygon_rows(std::span<const Eigen::Vector2d> polygon, int width, int height, int step, Visit visit) {
    const std::size_t count = polygon.size();
    std::size_t topmost = 0;
    double bottom = polygon[0].y();
    for (std::size_t i = 1; i < count; ++i) {
        if (polygon[i].y() < polygon[topmost].y()) topmost = i;
        bottom = std::max(bottom, polygon[i].y());
    }
    const double top = polygon[topmost].y();
    if (!(bottom >= 0 && top <= height - 1)) return;
    const int first = static_cast<int>(std::ceil(std::max(top, 0.0)));
    const int last = static_cast<int>(std::floor(std::min(bottom, height - 1.0)));
    // Two chains of edges run down from the topmost corner; each row lies between one edge of either chain.
    struct Chain {
        std::size_t at;     // corner at which the edge begins
        double x = 0;       // px, in row 0
        double slope = 0;   // px to the right per row
        int last_row = -1;  // of the edge
    };
    const auto go_down_to = [&](Chain& chain, bool forward, int y) {
        const auto after = [&](std::size_t at) { return forward ? (at + 1 == count ? 0 : at + 1) : (at == 0 ? count : at) - 1; };
        std::size_t next = after(chain.at);
        for (std::size_t guard = 0; guard < count && polygon[next].y() < y; ++guard) {
            chain.at = next;
            next = after(next);
        }
        const Eigen::Vector2d edge = polygon[next] - polygon[chain.at];
        chain.slope = edge.y() > 1e-9 ? edge.x() / edge.y() : 0;
        chain.x = polygon[next].x() - chain.slope * polygon[next].y();
        chain.last_row = std::max(static_cast<int>(std::min(polygon[next].y(), static_cast<double>(last))), y);
    };
    Chain one{topmost}, other{topmost};
    for (int y = (first + step - 1) / step * step; y <= last;) {
        if (y > one.last_row) go_down_to(one, true, y);
        if (y > other.last_row) go_down_to(other, false, y);
        for (const int stop = std::min(one.last_row, other.last_row); y <= stop; y += step) {
            const double a = one.x + one.slope * y;
            const double b = other.x + other.slope * y;
            const double low = std::min(std::max(std::min(a, b), 0.0), static_cast<double>(width));
            const double high = std::max(std::min(std::max(a, b), width - 1.0), -1.0);
            const int begin = static_cast<int>(std::ceil(low));
            const int end = static_cast<int>(high + 1);
            if (begin < end) visit(y, begin, end);
        }
    }
}

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
