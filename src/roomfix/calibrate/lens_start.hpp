// Where the solution of a lens calibration starts from.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "roomfix/calibrate/chessboard.hpp"
#include "roomfix/geometry/camera_model.hpp"

namespace roomfix {

/// Where a board was before a camera.
struct BoardPose {
    Eigen::Isometry3d camera_from_board;
    double squares = 0;  // px^2: how far its corners are from those seen, squared and summed
};

/// By a shot's corners. Nothing where the camera cannot see one of them, or no pose explains them.
std::optional<BoardPose> pose_of_board(const CameraModel& camera, const BoardShot& shot, const Chessboard& board);

/// A camera and where the boards were before it.
struct LensStart {
    CameraModel model;
    std::vector<std::optional<Eigen::Isometry3d>> camera_from_board;  // of each shot; nothing where no pose explains its corners
};

/// A lens without distortion, or an equidistant one without more of it, of the one among many focal lengths that explains most boards, and those
/// best. (OpenCV's own start does not find fisheyes whose boards were shown strongly tilted, and its last digits change from run to run.)
LensStart start_of_lens(const std::vector<const BoardShot*>& shots, int width, int height, const Chessboard& board, Distortion kind);

}  // namespace roomfix
