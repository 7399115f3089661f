#include "roomfix/connect/ros_fix.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "roomfix/connect/ros_names.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix::ros {
namespace {

constexpr double height_variance = 1e-4;                             // m^2; of speeds m^2/s^2
constexpr double tilt_variance = 1e-4;                               // rad^2, roll and pitch
constexpr double any_yaw = std::numbers::pi * std::numbers::pi / 3;  // rad^2, of all directions alike
constexpr std::array<std::size_t, 3> planar_axes = {0, 1, 5};        // x, y, yaw among the six
constexpr std::size_t row = 6;

/// Diagonal alone.
Covariance flat_floor() {
    Covariance covariance = {};
    covariance[2 * row + 2] = height_variance;
    covariance[3 * row + 3] = covariance[4 * row + 4] = tilt_variance;
    return covariance;
}

template <int size>
bool is_covariance(const Eigen::Matrix<double, size, size>& m) {
    return m.allFinite() && m.isApprox(m.transpose(), 1e-6) && Eigen::LLT<Eigen::Matrix<double, size, size>>(m).info() == Eigen::Success;
}

}  // namespace

bool has_pose(const Fix& fix) {
    if (fix.status == FixStatus::none || !std::isfinite(fix.pose.x) || !std::isfinite(fix.pose.y)) return false;
    if (!fix.yaw_known) return is_covariance<2>(fix.covariance.topLeftCorner<2, 2>());
    return std::isfinite(fix.pose.yaw) && is_covariance<3>(fix.covariance);
}

Pose pose_of(const Pose2& pose) { return {{pose.x, pose.y, 0}, Eigen::Quaterniond(std::cos(0.5 * pose.yaw), 0, 0, std::sin(0.5 * pose.yaw))}; }

Covariance planar_covariance(const Eigen::Matrix3d& covariance, bool yaw_known) {
    Covariance all = flat_floor();
    const std::size_t known = yaw_known ? 3 : 2;
    for (std::size_t i = 0; i < known; ++i) {
        for (std::size_t j = 0; j < known; ++j) {
            all[planar_axes[i] * row + planar_axes[j]] = covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
    }
    if (!yaw_known) all[5 * row + 5] = any_yaw;
    return all;
}

PoseWithCovarianceStamped pose_message(const Fix& fix) {
    const Pose2 pose{fix.pose.x, fix.pose.y, fix.yaw_known ? fix.pose.yaw : 0};
    return {{fix.time, map_frame}, pose_of(pose), planar_covariance(fix.covariance, fix.yaw_known)};
}

bool has_twist(const Fix& fix) {
    return fix.yaw_known && has_pose(fix) && fix.velocity && fix.velocity->allFinite() && is_covariance<3>(fix.velocity_covariance);
}

Odometry odometry_message(const Fix& fix, const std::string& child) {
    const Eigen::Matrix3d own_from_map = Eigen::AngleAxisd(-fix.pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();  // of velocities
    const Eigen::Vector3d own = own_from_map * fix.velocity.value_or(Eigen::Vector3d::Zero());
    const Eigen::Vector3d by_yaw(own.y(), -own.x(), 0);
    const Eigen::Matrix3d covariance = own_from_map * fix.velocity_covariance * own_from_map.transpose() + fix.covariance(2, 2) * by_yaw * by_yaw.transpose();
    Odometry message{{fix.time, map_frame}, child, pose_of(fix.pose), planar_covariance(fix.covariance, true)};
    message.linear = {own.x(), own.y(), 0};
    message.angular = {0, 0, own.z()};
    message.twist_covariance = planar_covariance(covariance, true);
    return message;
}

TransformStamped transform_message(Nanoseconds time, const std::string& frame, const std::string& child, const Pose2& frame_from_child) {
    return {{time, frame}, child, pose_of(frame_from_child)};
}

Pose2 map_from_odom(const Pose2& map_from_base, const Pose2& odom_from_base) {
    const double yaw = wrap_angle(map_from_base.yaw - odom_from_base.yaw);
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {map_from_base.x - (c * odom_from_base.x - s * odom_from_base.y), map_from_base.y - (s * odom_from_base.x + c * odom_from_base.y), yaw};
}

CameraInfo camera_info_message(Nanoseconds time, const std::string& frame, const CameraModel& model) {
    CameraInfo info;
    info.header = {time, frame};
    info.height = static_cast<std::uint32_t>(model.height);
    info.width = static_cast<std::uint32_t>(model.width);
    info.distortion_model = name_of(model.kind);
    info.d.assign(model.distortion.begin(), model.distortion.begin() + distortion_count(model.kind));
    info.k = {model.fx, 0, model.cx, 0, model.fy, model.cy, 0, 0, 1};
    info.p = {model.fx, 0, model.cx, 0, 0, model.fy, model.cy, 0, 0, 0, 1, 0};
    return info;
}

}  // namespace roomfix::ros
