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
    const double wrapped = std::remainder(radians, 2 * std::numbers::pi);
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
inline Eigen::Isometry3d map_from_robot(const Pose2& pose) {
    Eigen::Isometry3d placed = Eigen::Isometry3d::Identity();
    placed.linear() = Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    placed.translation() = Eigen::Vector3d(pose.x, pose.y, 0);
    return placed;
}

/// map_from_camera (or another rigid transform) with its covariance.
/// Order (x, y, z, rotation about X, Y, Z), fixed axes of the target frame, m and rad, as in ROS:
/// true position = position + d[0..2], true rotation = Exp(d[3..5]) * rotation.
struct UncertainPose3 {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    Matrix6d covariance = Matrix6d::Zero();
};

/// The rotation by the angle |v| about the axis v (Rodrigues); rad.
inline Eigen::Matrix3d exponential_rotation(const Eigen::Vector3d& v) {
    const double angle = v.norm();
    if (angle < 1e-300) return Eigen::Matrix3d::Identity();
    return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

/// The inverse: axis times angle (rad, 0..pi) of a rotation.
inline Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
    const Eigen::AngleAxisd turn(rotation);
    return turn.angle() * turn.axis();
}

/// The matrix of the cross product: skew(a) * b = a x b.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
    Eigen::Matrix3d m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
}

/// `pose` moved by the error vector `d` in the convention of UncertainPose3.
inline Eigen::Isometry3d perturbed(const Eigen::Isometry3d& pose, const Vector6d& d) {
    Eigen::Isometry3d moved = pose;
    moved.translation() += d.head<3>();
    moved.linear() = exponential_rotation(d.tail<3>()) * pose.linear();
    return moved;
}

/// The inverse: the error vector that moves `from` to `to`.
inline Vector6d error_between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
    Vector6d d;
    d << to.translation() - from.translation(), rotation_vector(to.linear() * from.linear().transpose());
    return d;
}

/// map_from_camera of a camera at `position` whose optical axis points at `target` (m, map), without roll.
/// The axis must not be vertical.
inline Eigen::Isometry3d looking_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
    const Eigen::Vector3d forward = (target - position).normalized();
    const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear().col(0) = right;
    pose.linear().col(1) = forward.cross(right);
    pose.linear().col(2) = forward;
    pose.translation() = position;
    return pose;
}

}  // namespace roomfix
