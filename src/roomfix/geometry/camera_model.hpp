// Pinhole camera with plumb_bob (Brown-Conrady) distortion, as in ROS camera_info and OpenCV.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

namespace roomfix {

/// x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), y' likewise; u = fx x' + cx, v = fy y' + cy.
/// Pixels: the centre of the top-left pixel is (0, 0).
struct CameraModel {
    int width = 0;
    int height = 0;
    double fx = 1;
    double fy = 1;
    double cx = 0;
    double cy = 0;
    std::array<double, 5> distortion = {0, 0, 0, 0, 0};  // k1, k2, p1, p2, k3
    double max_radius_squared = 1e30;                    // set by prepare(): the model folds back beyond this r^2

    /// Finds the radius up to which the distortion is invertible. Call once after filling in the numbers.
    void prepare();

    bool contains(const Eigen::Vector2d& pixel, double margin = 0) const {
        return pixel.x() >= margin && pixel.y() >= margin && pixel.x() <= width - 1 - margin && pixel.y() <= height - 1 - margin;
    }
};

/// A camera model with its size and parameters, ready to use.
CameraModel make_camera_model(int width, int height, double fx, double fy, double cx, double cy, const std::array<double, 5>& distortion = {0, 0, 0, 0, 0});

/// d(pixel) / d(point in the camera frame), px/m.
using ProjectionJacobian = Eigen::Matrix<double, 2, 3>;

/// The pixel of a point in the camera frame (m). Nothing if the point is not in front of the camera or lies outside the
/// part of the view where the distortion model is invertible.
std::optional<Eigen::Vector2d> project(const CameraModel& model, const Eigen::Vector3d& point_camera, ProjectionJacobian* jacobian = nullptr);

/// The point (x/z, y/z) on the ray through a pixel; project() of (x/z, y/z, 1) gives the pixel back within 1e-9 px.
/// `jacobian`, if asked for, is d(x/z, y/z) / d(pixel). Nothing where the model has no inverse.
std::optional<Eigen::Vector2d> unproject(const CameraModel& model, const Eigen::Vector2d& pixel, Eigen::Matrix2d* jacobian = nullptr);

}  // namespace roomfix
