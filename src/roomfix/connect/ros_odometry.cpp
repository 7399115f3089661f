#include "roomfix/connect/ros_odometry.hpp"

#include <fmt/format.h>

#include <cmath>

#include "roomfix/connect/ros_names.hpp"

namespace roomfix {
namespace {

constexpr double unit_within = 0.1;      // a quaternion may be so much longer or shorter than 1
constexpr double nobody_knows = 1000;    // m^2: a variance of a place that says that it is none
constexpr double farthest_driven = 1e7;  // m from where the wheels began

/// All of the pose is zero, and the variance of its place huge, or negative as some write it: the message is about the twist alone.
bool is_twist_only(const ros::Odometry& message) {
    const Eigen::Quaterniond& q = message.pose.orientation;
    const bool turned = q.x() != 0 || q.y() != 0 || q.z() != 0;
    const double variance = message.pose_covariance[0];
    return message.pose.position.isZero(0) && !turned && (variance >= nobody_knows || variance < 0);
}

}  // namespace

Result<Pose2> pose_of_wheels(const ros::Odometry& message) {
    const std::string& frame = message.header.frame_id;
    if (frame == map_frame || frame == "/" + map_frame) return Error{"its frame is 'map': that is where a localiser sees the robot, not what its wheels say"};
    if (is_twist_only(message)) {
        return Error{"it has a twist, but no pose (all zero, with a variance that says so), and speeds are not added up here: let the robot's node do that"};
    }
    const Eigen::Quaterniond& q = message.pose.orientation;
    const Eigen::Vector3d& place = message.pose.position;
    if (!place.allFinite() || !q.coeffs().allFinite()) return Error{"its pose is not finite"};
    if (std::abs(q.norm() - 1) > unit_within) return Error{"its orientation is no quaternion of length 1"};
    if (std::abs(place.x()) > farthest_driven || std::abs(place.y()) > farthest_driven) return Error{"its place is farther away than wheels can drive"};
    const double ahead = q.w() * q.w() + q.x() * q.x() - q.y() * q.y() - q.z() * q.z(), left = 2 * (q.w() * q.z() + q.x() * q.y());
    return Pose2{place.x(), place.y(), std::atan2(left, ahead)};
}

Result<OdometryObservation> RosOdometry::report_of(std::span<const std::uint8_t> message, Nanoseconds arrival, double steady) {
    const auto odometry = ros::decode_odometry(message);
    if (!odometry) return Error{"it is no nav_msgs/msg/Odometry in plain CDR with a time that ROS can state"};
    const auto pose = pose_of_wheels(*odometry);
    if (!pose) return pose.error();
    stamped_ = odometry->header.stamp != 0;
    return OdometryObservation{stamped_ ? clock_.ours(odometry->header.stamp, arrival, steady) : arrival, robot_, *pose};
}

OdometryBatch RosOdometry::read(std::span<const std::uint8_t> message, Nanoseconds arrival, double steady) {
    const auto report = report_of(message, arrival, steady);
    used_last_ = static_cast<bool>(report);
    if (report) return {{*report}, {}};
    const bool is_new = report.error().message != why_not_;
    ++not_used_;
    why_not_ = report.error().message;
    if (!is_new) return {};
    return {{}, {why_not_}};
}

std::string RosOdometry::told() const {
    std::string text = !used_last_ ? "" : stamped_ ? clock_.told() : "its messages have no time: each is taken to be as old as its arrival";
    if (not_used_ == 0) return text;
    if (!text.empty()) text += "; ";
    return text + fmt::format("{} messages were not used, the last since {}", not_used_, why_not_);
}

}  // namespace roomfix
