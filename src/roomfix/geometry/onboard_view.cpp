#include "roomfix/geometry/onboard_view.hpp"

namespace roomfix {

CalibrationRoot calibration_root(const CameraOnRobot& camera) {
    constexpr double distance = 2;  // m: about how far a ceiling is
    const auto pixels = spread_pixels(camera.model);
    Eigen::Matrix<double, Eigen::Dynamic, camera_errors> effect(2 * pixels.cols(), camera_errors);
    Eigen::Index rows = 0;
    for (Eigen::Index i = 0; i < pixels.cols(); ++i) {
        const auto ray = unproject(camera.model, pixels.col(i));
        SeenPointJacobian j;
        if (!ray || !predict_point(camera, {}, camera.robot_from_camera.pose * (distance * ray->homogeneous()), &j)) continue;
        effect.middleRows<2>(rows) << j.by_mount, j.by_intrinsics;
        rows += 2;
    }
    return calibration_root(camera.robot_from_camera.covariance, camera.intrinsics, effect.topRows(rows));
}

std::optional<Eigen::Vector2d> predict_point(const CameraOnRobot& camera, const Pose2& pose, const Eigen::Vector3d& map_point, SeenPointJacobian* jacobian) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(-pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Vector3d in_robot = turn * (map_point - Eigen::Vector3d(pose.x, pose.y, 0));
    const Eigen::Isometry3d& mount = camera.robot_from_camera.pose;
    const Eigen::Matrix3d camera_from_robot = mount.linear().transpose();
    const Eigen::Vector3d way = in_robot - mount.translation();
    ProjectionJacobian by_camera_point;
    const bool uncertain = jacobian && camera.intrinsics.any();
    if (jacobian && !uncertain) jacobian->by_intrinsics.setZero();
    const auto pixel = project(camera.model, camera_from_robot * way, jacobian ? &by_camera_point : nullptr, uncertain ? &jacobian->by_intrinsics : nullptr);
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
