// Angles, poses on the floor and poses in space with their uncertainty.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace roomfix {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The same angle in (-pi, pi].
inline double wrap_angle(double radians) {
    // Most angles are hardly more than one turn off; there a subtraction gives the same to the last bit, in a tenth of the time.
    constexpr double turn = 2 * std::numbers::pi;
    const bool near = std::abs(radians) < 1.4 * turn;
    const double wrapped = !near ? std::remainder(radians, turn) : radians > 0.5 * turn ? radians - turn : radians < -0.5 * turn ? radians + turn : radians;
    return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

/// The representative of `radians` modulo `period` that is nearest to `reference`.
inline double nearest_angle(double radians, double reference, double period) { return reference + std::remainder(radians - reference, period); }

constexpr double degrees(double radians) { return radians * 180 / std::numbers::pi; }
constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// A pose on the floor of the map: m, m, rad counter-clockwise from the map's x axis.
struct Pose2 {
    double x = 0;
    double y = 0;
    double yaw = 0;
};

/// The robot's frame in the map: origin on the floor, x forward.
Eigen::Isometry3d map_from_robot(const Pose2& pose);

/// map_from_camera (or another rigid transform) with its covariance.
/// Order (x, y, z, rotation about X, Y, Z), fixed axes of the target frame, m and rad, as in ROS:
/// true position = position + d[0..2], true rotation = Exp(d[3..5]) * rotation.
struct UncertainPose3 {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    Matrix6d covariance = Matrix6d::Zero();
};

/// The rotation by the angle |v| about the axis v (Rodrigues); rad.
Eigen::Matrix3d exponential_rotation(const Eigen::Vector3d& v);

/// The inverse: axis times angle (rad, 0..pi) of a rotation.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation);

/// The matrix of the cross product: skew(a) * b = a x b.
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// `pose` moved by the error vector `d` in the convention of UncertainPose3.
Eigen::Isometry3d perturbed(const Eigen::Isometry3d& pose, const Vector6d& d);

/// The inverse: the error vector that moves `from` to `to`.
Vector6d error_between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to);

/// map_from_camera of a camera at `position` whose optical axis points at `target` (m, map), without roll.
/// The axis must not be vertical.
Eigen::Isometry3d looking_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target);

}  // namespace roomfix
