#include "roomfix/geometry/pose.hpp"

namespace roomfix {

Eigen::Isometry3d map_from_robot(const Pose2& pose) {
    Eigen::Isometry3d placed = Eigen::Isometry3d::Identity();
    placed.linear() = Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    placed.translation() = Eigen::Vector3d(pose.x, pose.y, 0);
    return placed;
}

Eigen::Matrix3d exponential_rotation(const Eigen::Vector3d& v) {
    const double angle = v.norm();
    if (angle < 1e-300) return Eigen::Matrix3d::Identity();
    return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
    const Eigen::AngleAxisd turn(rotation);
    return turn.angle() * turn.axis();
}

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
    Eigen::Matrix3d m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
}

Eigen::Isometry3d perturbed(const Eigen::Isometry3d& pose, const Vector6d& d) {
    Eigen::Isometry3d moved = pose;
    moved.translation() += d.head<3>();
    moved.linear() = exponential_rotation(d.tail<3>()) * pose.linear();
    return moved;
}

Vector6d error_between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
    Vector6d d;
    d << to.translation() - from.translation(), rotation_vector(to.linear() * from.linear().transpose());
    return d;
}

Eigen::Isometry3d looking_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
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
