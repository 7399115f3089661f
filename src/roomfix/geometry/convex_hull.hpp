// Convex hulls of small point sets.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace roomfix {

/// Indices of the convex hull of `points`, so that the interior lies on the side of positive cross product (counter-clockwise
/// with y up, clockwise on the screen with y down). Collinear points are left out. `hull` and `order` must have room for
/// points.size() + 1 indices; returns how many of `hull` are used. No allocation.
/// Source: Andrew's monotone chain, 1979.
int convex_hull(std::span<const Eigen::Vector2d> points, std::span<int> order, std::span<int> hull);

/// Sorts points from left to right by insertion, which is fast where they nearly are in this order.
void sort_nearly_sorted(std::span<Eigen::Vector2d> points);

/// As convex_hull(), of points that are sorted from left to right. `hull` gets the corners themselves and must have room for points.size() + 1.
int convex_hull_of_sorted(std::span<const Eigen::Vector2d> points, std::span<Eigen::Vector2d> hull);

/// The corners of the hull themselves, in the same order.
std::vector<Eigen::Vector2d> hull_of(const std::vector<Eigen::Vector2d>& points);

}  // namespace roomfix
