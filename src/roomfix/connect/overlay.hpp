// A camera's picture with what was found drawn on it.
#pragma once

#include <filesystem>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/connect/drawing.hpp"
#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// Writes the frame, small ones enlarged, with everything that was seen in it as PNG or JPEG.
Result<void> save_overlay(const std::filesystem::path& file, LumaView frame, const Drawing& drawing);

/// Writes the frame with a grid of metres on the floor (map axes), the pixels that a calibration rests on, and where the map's origin and
/// axes are, if in sight.
Result<void> save_floor_overlay(const std::filesystem::path& file, LumaView frame, const View& view, const std::vector<Eigen::Vector2d>& seen);

/// Writes the frame with edges that were followed through it, those that are believed to be straight in truth and others, px.
Result<void> save_edges_overlay(const std::filesystem::path& file, LumaView frame, const std::vector<std::vector<Eigen::Vector2d>>& straight,
                                const std::vector<std::vector<Eigen::Vector2d>>& others);

}  // namespace roomfix
