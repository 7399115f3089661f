// A camera in its place: from the map to pixels and from pixels to planes of the map.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "roomfix/geometry/calibration.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

/// A camera model with its uncertain pose in the map.
struct View {
    CameraModel model;
    UncertainPose3 map_from_camera;
    CalibrationRoot calibration = CalibrationRoot::Zero();  // all that is uncertain of both
    bool intrinsics_uncertain = false;

    View() = default;
    View(const CameraModel& camera, const UncertainPose3& pose, const IntrinsicsErrors& intrinsics = {});

    Eigen::Vector3d position() const { return map_from_camera.pose.translation(); }
};

/// Derivatives of a map point's pixel.
struct ViewJacobian {
    Eigen::Matrix<double, 2, 3> by_point;  // px/m, map frame
    Eigen::Matrix<double, 2, 6> by_pose;   // px by the error vector of UncertainPose3
    IntrinsicsJacobian by_intrinsics;      // only where the view's intrinsics are uncertain

    /// Of what moves with the pixel by `of_pixel`: its derivatives by the view's six independent errors.
    template <class OfPixel>
    auto by_calibration(const View& view, const OfPixel& of_pixel) const {
        Eigen::Matrix<double, OfPixel::RowsAtCompileTime, 6> by = (of_pixel * by_pose) * view.calibration.topRows<6>();
        if (view.intrinsics_uncertain) by += (of_pixel * by_intrinsics) * view.calibration.bottomRows<most_intrinsics>();
        return by;
    }
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

/// How a plane point moves with the view's six independent errors (m).
std::optional<Eigen::Matrix<double, 2, 6>> plane_point_by_calibration(const View& view, const PlanePoint& point, double height);

}  // namespace roomfix
