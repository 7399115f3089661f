#include "roomfix/geometry/view.hpp"

#include <Eigen/LU>

namespace roomfix {

std::optional<Eigen::Vector2d> project_map_point(const View& view, const Eigen::Vector3d& point_map, ViewJacobian* jacobian) {
    const Eigen::Matrix3d camera_from_map = view.map_from_camera.pose.linear().transpose();
    const Eigen::Vector3d offset_map = point_map - view.position();
    ProjectionJacobian by_camera_point;
    const auto pixel = project(view.model, camera_from_map * offset_map, jacobian ? &by_camera_point : nullptr);
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

}  // namespace roomfix
