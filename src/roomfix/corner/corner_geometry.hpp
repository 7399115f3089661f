// A corner of a room and the three lines that it draws in a picture, both ways.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/observation/corner_observation.hpp"

namespace roomfix {

/// Three half-lines from a common point, on the plane at distance 1 before the camera (x to the right, y down).
struct CornerRays {
    Eigen::Vector2d corner = Eigen::Vector2d::Zero();
    std::array<Eigen::Vector2d, 3> directions;  // of unit length, away from the corner; x edge, y edge, the walls' edge
};

/// Settings state lengths for a picture 640 px wide: so many of the model's pixels are one of theirs.
inline double length_unit(const CameraModel& model) { return model.width / 640.0; }

/// Unit directions of the edges, away from the corner, in the corner's frame: x edge, y edge (`wall_angle` to the left of x, rad), down.
std::array<Eigen::Vector3d, 3> edge_directions(double wall_angle);

/// The picture of a corner. Nothing if the corner is behind the camera or an edge points straight at it.
std::optional<CornerRays> corner_rays(const CornerView& view, double wall_angle);

/// Where a camera sees the corner, px; nothing where corner_rays() has none.
std::optional<Eigen::Vector2d> corner_pixel(const CameraModel& model, const CornerView& view, double wall_angle);

/// The camera that sees these half-lines: inside the room, below the ceiling. Two at most, and for walls at a right angle one; nothing
/// where no such corner draws them. Source: perspective of three orthogonal angles (Briales and Gonzalez-Jimenez 2016) for three lines
/// through one point, extended to walls at any angle.
struct CornerSolutions {
    int count = 0;
    std::array<CornerView, 2> views;
};
CornerSolutions solve_corner(const CornerRays& rays, double wall_angle);

/// The same lines with each of the three as the walls' edge; of the two orders of the others only one is a corner seen from inside.
std::array<CornerRays, 3> labellings(const CornerRays& rays);

/// True if the camera is in the room that the corner belongs to: between the walls, below the ceiling.
bool is_inside(const CornerView& view, double wall_angle);

}  // namespace roomfix
