#include "roomfix/geometry/view.hpp"

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

/// How points of the floor in sight move with all errors (m).
Eigen::Matrix<double, Eigen::Dynamic, camera_errors> floor_effect(const View& view) {
    const auto pixels = spread_pixels(view.model);
    Eigen::Matrix<double, Eigen::Dynamic, camera_errors> effect(2 * pixels.cols(), camera_errors);
    Eigen::Index rows = 0;
    for (Eigen::Index i = 0; i < pixels.cols(); ++i) {
        const auto floor = pixel_to_plane(view, pixels.col(i), 0);
        constexpr double farthest = 8;  // times the camera's height: nobody locates robots beyond
        if (!floor || (floor->point - view.position().head<2>()).norm() > farthest * view.position().z()) continue;
        IntrinsicsJacobian by_intrinsics;
        const Eigen::Vector3d in_camera = view.map_from_camera.pose.inverse() * Eigen::Vector3d(floor->point.x(), floor->point.y(), 0);
        if (!project(view.model, in_camera, nullptr, &by_intrinsics)) continue;
        effect.middleRows<2>(rows) << floor->by_pose, -floor->by_pixel * by_intrinsics;
        rows += 2;
    }
    return effect.topRows(rows);
}

}  // namespace

View::View(const CameraModel& camera, const UncertainPose3& pose, const IntrinsicsErrors& intrinsics)
    : model(camera), map_from_camera(pose), intrinsics_uncertain(intrinsics.any()) {
    if (intrinsics_uncertain) {
        map_from_camera.covariance = joint_covariance(pose.covariance, intrinsics).topLeftCorner<6, 6>();
        calibration = calibration_root(pose.covariance, intrinsics, floor_effect(*this));
    } else {
        calibration.topRows<6>() = root_of(pose.covariance);
    }
}

std::optional<Eigen::Vector2d> project_map_point(const View& view, const Eigen::Vector3d& point_map, ViewJacobian* jacobian) {
    const Eigen::Matrix3d camera_from_map = view.map_from_camera.pose.linear().transpose();
    const Eigen::Vector3d offset_map = point_map - view.position();
    ProjectionJacobian by_camera_point;
    const auto pixel = project(view.model, camera_from_map * offset_map, jacobian ? &by_camera_point : nullptr,
                               jacobian && view.intrinsics_uncertain ? &jacobian->by_intrinsics : nullptr);
    if (pixel && jacobian) {
        // p_camera = R^T (p_map - t), R = Exp(d) R0: d(p_camera)/d(d) = R0^T skew(p_map - t)
        jacobian->by_point = by_camera_point * camera_from_map;
        jacobian->by_pose.leftCols<3>() = -jacobian->by_point;
        jacobian->by_pose.rightCols<3>() = jacobian->by_point * skew(offset_map);
    }
    return pixel;
}

std::optional<PlanePoint> pixel_to_plane(const View& view, const Eigen::Vector2d& pixel, double height) {
    Eigen::Matrix2d ray_by_pixel;
    const auto ray = unproject(view.model, pixel, &ray_by_pixel);
    if (!ray) return std::nullopt;
    const Eigen::Matrix3d rotation = view.map_from_camera.pose.linear();
    const Eigen::Vector3d direction = rotation * ray->homogeneous();
    const double drop = height - view.position().z();
    if (std::abs(direction.z()) < 1e-12 || !(drop / direction.z() > 0)) return std::nullopt;
    const double scale = drop / direction.z();

    // point = t + s d with s = (height - t_z) / d_z; a change of d moves the point by s (I - d e_z^T / d_z) dd.
    const Eigen::Matrix<double, 2, 3> by_direction =
        scale * (Eigen::Matrix3d::Identity() - direction * Eigen::RowVector3d::UnitZ() / direction.z()).topRows<2>();
    PlanePoint result;
    result.point = view.position().head<2>() + scale * direction.head<2>();
    result.by_pixel = by_direction * rotation.leftCols<2>() * ray_by_pixel;
    result.by_pose.leftCols<2>().setIdentity();
    result.by_pose.col(2) = -direction.head<2>() / direction.z();
    result.by_pose.rightCols<3>() = -by_direction * skew(direction);
    return result;
}

std::optional<Eigen::Matrix<double, 2, 6>> plane_point_by_calibration(const View& view, const PlanePoint& point, double height) {
    ViewJacobian j;
    if (!project_map_point(view, {point.point.x(), point.point.y(), height}, &j)) return std::nullopt;
    // The pixel stays: the point moves against what the pixel would.
    return Eigen::Matrix<double, 2, 6>(-j.by_calibration(view, point.by_pixel));
}

}  // namespace roomfix
