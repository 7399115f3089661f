#include "roomfix/evaluate/robot_point.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr double shortest_way = 0.02;  // m: a shorter way has no direction

Pose2 shifted(const Pose2& pose, const Eigen::Vector2d& by) {
    const Eigen::Vector2d way = Eigen::Rotation2Dd(pose.yaw) * by;
    return {pose.x + way.x(), pose.y + way.y(), pose.yaw};
}

/// The fixes of one robot that have a yaw, in the order of their times.
std::vector<StampedPose> turned_fixes(const std::vector<Fix>& fixes, const std::string& robot) {
    std::vector<StampedPose> poses;
    for (const Fix& fix : fixes) {
        if (fix.robot == robot && fix.status != FixStatus::none && fix.yaw_known) poses.push_back({fix.time, fix.pose});
    }
    std::stable_sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
    return poses;
}

}  // namespace

Eigen::Matrix3d point_from_middle(const Eigen::Vector2d& point, double yaw) {
    const Eigen::Vector2d arm = Eigen::Rotation2Dd(yaw) * point;
    Eigen::Matrix3d derivatives = Eigen::Matrix3d::Identity();
    derivatives(0, 2) = -arm.y();
    derivatives(1, 2) = arm.x();
    return derivatives;
}

std::optional<Fix> fix_of_point(const Fix& fix, const Eigen::Vector2d& point) {
    if (point.isZero(0)) return fix;
    if (!fix.yaw_known) return std::nullopt;
    Fix there = fix;
    there.pose = shifted(fix.pose, point);
    const Eigen::Matrix3d derivatives = point_from_middle(point, fix.pose.yaw);
    there.covariance = derivatives * fix.covariance * derivatives.transpose();
    return there;
}

Truth true_middles(const Truth& truth, const std::vector<Fix>& fixes, const Eigen::Vector2d& point) {
    Truth middles = truth;
    for (auto& [robot, poses] : middles) {
        const std::vector<StampedPose>& points = truth.at(robot);
        const std::vector<StampedPose> turned = turned_fixes(fixes, robot);
        double course = 0;
        for (std::size_t i = 0; i < poses.size(); ++i) {
            const Pose2 &before = points[i > 0 ? i - 1 : i].pose, &after = points[std::min(i + 1, points.size() - 1)].pose;
            if (std::hypot(after.x - before.x, after.y - before.y) > shortest_way) course = std::atan2(after.y - before.y, after.x - before.x);
            if (!poses[i].yaw_known) {
                const auto own = pose_at(points, poses[i].time), fixed = pose_at(turned, poses[i].time);
                poses[i].pose.yaw = own && own->yaw_known ? own->yaw : fixed && fixed->yaw_known ? fixed->yaw : course;
                poses[i].yaw_known = true;
            }
            poses[i].pose = shifted(poses[i].pose, -point);
        }
    }
    return middles;
}

}  // namespace roomfix
