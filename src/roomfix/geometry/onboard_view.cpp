#include "roomfix/geometry/onboard_view.hpp"

namespace roomfix {

std::optional<Eigen::Vector2d> predict_point(const CameraOnRobot& camera, const Pose2& pose, const Eigen::Vector3d& map_point, SeenPointJacobian* jacobian) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(-pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Vector3d in_robot = turn * (map_point - Eigen::Vector3d(pose.x, pose.y, 0));
    const Eigen::Isometry3d& mount = camera.robot_from_camera.pose;
    const Eigen::Matrix3d camera_from_robot = mount.linear().transpose();
    const Eigen::Vector3d way = in_robot - mount.translation();
    ProjectionJacobian by_camera_point;
    const auto pixel = project(camera.model, camera_from_robot * way, jacobian ? &by_camera_point : nullptr);
    if (!pixel || !jacobian) return pixel;
    const Eigen::Matrix<double, 2, 3> by_robot_point = by_camera_point * camera_from_robot;
    jacobian->by_point = by_robot_point * turn;
    jacobian->by_pose.leftCols<2>() = -jacobian->by_point.leftCols<2>();
    jacobian->by_pose.col(2) = -by_robot_point * Eigen::Vector3d::UnitZ().cross(in_robot);
    jacobian->by_mount.leftCols<3>() = -by_robot_point;
    jacobian->by_mount.rightCols<3>() = by_robot_point * skew(way);
    return pixel;
}

}  // namespace roomfix
