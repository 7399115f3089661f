// A camera in its place: from the map to pixels and from pixels to planes of the map.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

/// A camera model with its uncertain pose in the map.
struct View {
    CameraModel model;
    UncertainPose3 map_from_camera;

    Eigen::Vector3d position() const { return map_from_camera.pose.translation(); }
};

/// Derivatives of a map point's pixel.
struct ViewJacobian {
    Eigen::Matrix<double, 2, 3> by_point;  // px/m, map frame
    Eigen::Matrix<double, 2, 6> by_pose;   // px by the error vector of UncertainPose3
};

/// The pixel of a point of the map (m); nothing where project() gives nothing.
std::optional<Eigen::Vector2d> project_map_point(const View& view, const Eigen::Vector3d& point_map, ViewJacobian* jacobian = nullptr);

/// Where a pixel's ray meets the horizontal plane z = height (m, map).
struct PlanePoint {
    Eigen::Vector2d point;                // m, map x and y
    Eigen::Matrix2d by_pixel;             // m/px
    Eigen::Matrix<double, 2, 6> by_pose;  // m by the error vector of UncertainPose3
};

/// Nothing if the ray runs parallel to the plane or away from it, or the pixel has no ray.
std::optional<PlanePoint> pixel_to_plane(const View& view, const Eigen::Vector2d& pixel, double height);

}  // namespace roomfix
