// Pinhole camera with a lens that bends rays, as in ROS camera_info and OpenCV.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

namespace roomfix {

class LensGrid;

/// How the lens bends rays; the names are those of ROS. With x, y of the ray at z = 1 and r^2 = x^2 + y^2:
enum class Distortion : std::uint8_t {
    plumb_bob,            // k1 k2 p1 p2 k3: factor 1 + k1 r^2 + k2 r^4 + k3 r^6, and tangential p1, p2 (Brown-Conrady)
    rational_polynomial,  // k1 k2 p1 p2 k3 k4 k5 k6: the same over 1 + k4 r^2 + k5 r^4 + k6 r^6
    equidistant,          // k1 k2 k3 k4: with the angle t = atan(r), r becomes t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8) (Kannala-Brandt)
};
constexpr int most_distortion = 8;
constexpr int most_intrinsics = 4 + most_distortion;
constexpr int distortion_count(Distortion kind) { return kind == Distortion::plumb_bob ? 5 : kind == Distortion::rational_polynomial ? 8 : 4; }

/// The name that ROS uses; nothing for names that are none.
const char* name_of(Distortion kind);
std::optional<Distortion> distortion_named(std::string_view name);

/// Derivatives of a pixel by fx, fy, cx, cy and the distortion's numbers; zero beyond those that the kind has.
using IntrinsicsJacobian = Eigen::Matrix<double, 2, most_intrinsics>;
using IntrinsicsVector = Eigen::Matrix<double, most_intrinsics, 1>;
using IntrinsicsMatrix = Eigen::Matrix<double, most_intrinsics, most_intrinsics>;

/// u = fx x' + cx, v = fy y' + cy, where x', y' are the bent ray.
/// Pixels: the centre of the top-left pixel is (0, 0).
struct CameraModel {
    int width = 0;
    int height = 0;
    double fx = 1;
    double fy = 1;
    double cx = 0;
    double cy = 0;
    std::array<double, most_distortion> distortion = {};  // zeros beyond what the kind has
    Distortion kind = Distortion::plumb_bob;
    double max_radius_squared = 1e30;      // set by prepare(): the model folds back beyond this r^2
    std::shared_ptr<const LensGrid> grid;  // of a lens that no formula fits: pixels are corrected by it, and nothing is seen outside it

    /// Finds the radius up to which the distortion is invertible. Call once after filling in the numbers.
    void prepare();

    int intrinsics_count() const { return 4 + distortion_count(kind); }
    /// fx, fy, cx, cy and the distortion's numbers, as in IntrinsicsJacobian.
    IntrinsicsVector intrinsics() const;
    void set_intrinsics(const IntrinsicsVector& numbers);

    bool contains(const Eigen::Vector2d& pixel, double margin = 0) const {
        return pixel.x() >= margin && pixel.y() >= margin && pixel.x() <= width - 1 - margin && pixel.y() <= height - 1 - margin;
    }
};

/// A camera model with its size and parameters, ready to use.
CameraModel make_camera_model(int width, int height, double fx, double fy, double cx, double cy, const std::array<double, most_distortion>& distortion = {},
                              Distortion kind = Distortion::plumb_bob);

/// d(pixel) / d(point in the camera frame), px/m.
using ProjectionJacobian = Eigen::Matrix<double, 2, 3>;

/// The pixel of a point in the camera frame (m). Nothing if the point is not in front of the camera or lies outside the
/// part of the view where the distortion model is invertible.
std::optional<Eigen::Vector2d> project(const CameraModel& model, const Eigen::Vector3d& point_camera, ProjectionJacobian* jacobian = nullptr,
                                       IntrinsicsJacobian* by_intrinsics = nullptr);

/// The point (x/z, y/z) on the ray through a pixel; project() of (x/z, y/z, 1) gives the pixel back within 1e-9 px.
/// `jacobian`, if asked for, is d(x/z, y/z) / d(pixel). Nothing where the model has no inverse.
std::optional<Eigen::Vector2d> unproject(const CameraModel& model, const Eigen::Vector2d& pixel, Eigen::Matrix2d* jacobian = nullptr);
/// The same to rounding, faster where the undistorted point of a pixel nearby is known.
std::optional<Eigen::Vector2d> unproject_beside(const CameraModel& model, const Eigen::Vector2d& pixel, const std::optional<Eigen::Vector2d>& neighbour);

/// The same camera at another resolution of the same picture: all of it, scaled. Nothing if the shape of the picture is another one,
/// or the lens is described by a grid.
std::optional<CameraModel> rescaled(const CameraModel& model, int width, int height);

}  // namespace roomfix
