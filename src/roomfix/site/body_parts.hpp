// The convex parts that a robot's body is made of.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "roomfix/site/site.hpp"

namespace roomfix {

constexpr std::size_t most_parts = 64;  // of one body
constexpr std::size_t most_points_of_part = 64;

/// A box as its 8 corners; its own frame has the middle as origin.
ConvexPart box_part(const Box& box, const Eigen::Isometry3d& robot_from_part);

/// An upright cylinder as two rims of 16 points, a little outside the circle, so that the polygon has its mean radius.
ConvexPart cylinder_part(const Cylinder& cylinder, const Eigen::Isometry3d& robot_from_part);

/// Height of the lowest point (m). There must be points.
double lowest_point(const std::vector<ConvexPart>& parts);

/// The box around all points that stands on the floor with its middle above the robot's origin.
Box box_around(const std::vector<ConvexPart>& parts);

/// Are all points of the two bodies at the same places, up to `tolerance` (m)? The parts may come in any order.
bool same_parts(const std::vector<ConvexPart>& a, const std::vector<ConvexPart>& b, double tolerance);

/// Angle after which a body looks the same (rad): 2 pi, pi, pi / 2, or 0 if it is round.
double symmetry_of(const std::vector<ConvexPart>& parts);

}  // namespace roomfix
