// Camera calibrations as ROS keeps them (camera_info YAML), and as OpenCV writes them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "roomfix/base/result.hpp"
#include "roomfix/geometry/camera_model.hpp"

namespace roomfix {

struct CameraInfo {
    std::string name;
    CameraModel model;
};

/// Reads image_width, image_height, camera_matrix, distortion_model and distortion_coefficients. Errors name the key that is missing or
/// impossible.
Result<CameraInfo> parse_camera_info(std::string_view text);
Result<CameraInfo> load_camera_info(const std::filesystem::path& file);

/// The file that camera_calibration writes and camera_info_manager reads; the projection is that of the camera itself.
std::string camera_info_text(const CameraInfo& info);

}  // namespace roomfix
