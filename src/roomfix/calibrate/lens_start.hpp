// Where the solution of a lens calibration starts from.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "roomfix/calibrate/chessboard.hpp"
#include "roomfix/geometry/camera_model.hpp"

namespace roomfix {

/// A camera and where the boards were before it.
struct LensSolution {
    CameraModel model;
    std::vector<Eigen::Isometry3d> camera_from_board;  // of each shot
};

/// What OpenCV makes of the corners; of a fisheye, the best of many focal lengths. Nothing where no such lens explains the shots.
std::optional<LensSolution> start_of_lens(const std::vector<const BoardShot*>& shots, int width, int height, const Chessboard& board, Distortion kind);

}  // namespace roomfix
