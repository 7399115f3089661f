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

/// Calls visit(y, begin, end) for the pixels begin <= x < end of each `step`-th row whose centres are inside the polygon.
template <class Visit>
void for_polygon_rows(std::span<const Eigen::Vector2d> polygon, int width, int height, int step, Visit visit) {
    double top = polygon[0].y();
    double bottom = top;
    for (const auto& p : polygon) {
        top = std::min(top, p.y());
        bottom = std::max(bottom, p.y());
    }
    if (!(bottom >= 0 && top <= height - 1)) return;
    const int first = std::max(static_cast<int>(std::ceil(std::max(top, 0.0))), 0);
    const int last = static_cast<int>(std::floor(std::min(bottom, height - 1.0)));
    // Two chains of edges run down from the topmost corner; each row lies between one edge of either chain.
    const std::size_t count = polygon.size();
    std::size_t start = 0;
    for (std::size_t i = 1; i < count; ++i) {
        if (polygon[i].y() < polygon[start].y()) start = i;
    }
    struct Chain {
        std::size_t at, next;
        double slope = 0;  // px to the right per row
    };
    const auto after = [count](std::size_t at, bool forward) { return forward ? (at + 1 == count ? 0 : at + 1) : (at == 0 ? count : at) - 1; };
    const auto x_in_row = [&](Chain& chain, bool forward, int y) {
        bool moved = chain.at == chain.next;
        for (std::size_t guard = 0; guard < count; ++guard) {
            const std::size_t next = after(chain.at, forward);
            if (polygon[next].y() >= y) break;
            chain.at = next;
            moved = true;
        }
        if (moved) {
            chain.next = after(chain.at, forward);
            const Eigen::Vector2d edge = polygon[chain.next] - polygon[chain.at];
            chain.slope = edge.y() > 1e-9 ? edge.x() / edge.y() : 0;
        }
        const Eigen::Vector2d& from = chain.slope == 0 ? polygon[chain.next] : polygon[chain.at];
        return from.x() + chain.slope * (y - polygon[chain.at].y());
    };
    Chain one{start, start};
    Chain other{start, start};
    for (int y = first; y <= last; y += step) {
        const double left = x_in_row(one, true, y);
        const double right = x_in_row(other, false, y);
        const double low = std::clamp(std::min(left, right), -1.0, width + 1.0);
        const double high = std::clamp(std::max(left, right), -1.0, width + 1.0);
        const int begin = std::max(static_cast<int>(std::ceil(low)), 0);
        const int end = std::min(static_cast<int>(std::floor(high)) + 1, width);
        if (begin < end) visit(y, begin, end);
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
