// Pictures of something about flat, such as a calibration board held before a camera.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "roomfix/base/random.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/simulate/pixel_rays.hpp"
#include "roomfix/simulate/sensor.hpp"

namespace roomfix {

/// Light (0..1) at a point of the plane, m; what lies around it, too.
using FlatPattern = std::function<float(const Eigen::Vector2d&)>;

/// How far (m) a sheet that is not quite flat rises over the plane at a point of it.
using SheetHeight = std::function<double(const Eigen::Vector2d&)>;

/// A printed chessboard with its white margin on something grey. Its first inner corner is at (0, 0).
FlatPattern chessboard_pattern(int columns, int rows, double square);

/// Rays are traced once for each camera.
class PlanePictures {
public:
    PlanePictures(const CameraModel& camera, const SensorModel& sensor, std::uint64_t seed);

    /// `camera_from_plane`: the plane is z = 0 there. `height`: must be much smaller than the sheet; none for one that is flat. `motion`: of the plane,
    /// from the first row to the last, whose middle sees it where it is: shift, m, and turn, rad, in the frame of the camera (a rolling shutter). The same
    /// `index` gives the same noise.
    void render(const FlatPattern& pattern, const Eigen::Isometry3d& camera_from_plane, std::uint64_t index, LumaImage& picture, const SheetHeight& height = {},
                const Vector6d& motion = Vector6d::Zero());

private:
    static constexpr int fine = 6;  // rays in each direction for a pixel that is not all alike
    int width_, height_;
    std::uint64_t seed_;
    Sensor sensor_;
    PixelRays rays_;  // camera frame
    std::vector<float> light_;
};

/// How a person shows a board to a camera that has to be calibrated: near and far, everywhere in the picture, tilted in all directions, in quarter turns, and
/// always wholly in sight. `size`: of the stretch between its outer corners, m.
std::vector<Eigen::Isometry3d> board_poses(const CameraModel& camera, const Eigen::Vector2d& size, int count, Random& random);

}  // namespace roomfix
