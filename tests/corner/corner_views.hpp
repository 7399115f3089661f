// How cameras below a corner see it.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/geometry/pose.hpp"
#include "roomfix/observation/corner_observation.hpp"
#include "roomfix/simulate/room_shots.hpp"

namespace roomfix {

constexpr double right_angle = std::numbers::pi / 2;

/// A camera at `place` whose axis passes the corner by `off` (rad, about the map's axes), turned about its axis by `roll`.
inline CornerView looking(const Eigen::Vector2d& place, const Eigen::Vector3d& off, double roll) {
    const Eigen::Vector3d to_corner = Eigen::Vector3d(-place.x(), -place.y(), 1).normalized();
    const Eigen::Vector3d axis = exponential_rotation(off) * to_corner;
    const Eigen::Vector3d right = axis.cross(Eigen::Vector3d::UnitZ()).normalized();
    const Eigen::Vector3d down = axis.cross(right);
    CornerView view;
    view.place = place;
    view.corner_from_camera.col(0) = std::cos(roll) * right + std::sin(roll) * down;
    view.corner_from_camera.col(1) = -std::sin(roll) * right + std::cos(roll) * down;
    view.corner_from_camera.col(2) = axis;
    return view;
}

/// How the camera of a simulated picture sees its corner.
inline CornerView truth_of(const RoomShot& shot) {
    const Eigen::Vector3d from_corner = shot.map_from_camera.translation() - shot.corner.position;
    return {shot.map_from_camera.linear(), from_corner.head<2>() / -from_corner.z()};
}

/// The largest difference of any number of two views.
inline double difference(const CornerView& a, const CornerView& b) {
    return std::max((a.corner_from_camera - b.corner_from_camera).cwiseAbs().maxCoeff(), (a.place - b.place).cwiseAbs().maxCoeff());
}

/// Rotation about the corner's axes (rad) and place by which a found view is off.
inline Vector5d error_of(const CornerView& truth, const CornerView& found) {
    Vector5d error;
    error << rotation_vector(truth.corner_from_camera * found.corner_from_camera.transpose()), truth.place - found.place;
    return error;
}

}  // namespace roomfix
