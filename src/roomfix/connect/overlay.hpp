// A camera's picture with what was found drawn on it.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/corner/corner_observer.hpp"
#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/observation/landmark_observation.hpp"
#include "roomfix/observation/silhouette_observation.hpp"

namespace roomfix {

/// Writes the frame with each robot's outline, its heading on the floor and a label as PNG or JPEG. `labels` has one text
/// per observation.
Result<void> save_overlay(const std::filesystem::path& file, LumaView frame, const View& view, const std::vector<SilhouetteObservation>& observations,
                          const std::vector<std::string>& labels);

/// Writes the frame with a grid of metres on the floor (map axes), the pixels that a calibration rests on, and where the map's origin and
/// axes are, if in sight.
Result<void> save_floor_overlay(const std::filesystem::path& file, LumaView frame, const View& view, const std::vector<Eigen::Vector2d>& seen);

/// Writes the frame with edges that were followed through it, those that are believed to be straight in truth and others, px.
Result<void> save_edges_overlay(const std::filesystem::path& file, LumaView frame, const std::vector<std::vector<Eigen::Vector2d>>& straight,
                                const std::vector<std::vector<Eigen::Vector2d>>& others);

/// What a camera that looks up saw: landmarks with their names, spots that are none, lamps.
struct CeilingOverlay {
    std::vector<LandmarkObservation> landmarks;
    std::vector<std::string> names;
    std::vector<Eigen::Vector2f> rejected;  // px
    std::vector<std::array<int, 4>> lamps;  // px: left, top, right, bottom
    std::string caption;                    // along the lower edge
};

/// Writes the frame, enlarged `zoom` times, with what was seen in it as PNG or JPEG.
Result<void> save_ceiling_overlay(const std::filesystem::path& file, LumaView frame, const CeilingOverlay& overlay, int zoom = 2);

/// What a camera that looks for corners saw: the corner's three edges, and lines that are none of it.
struct CornerOverlay {
    std::optional<CornerObservation> corner;
    std::string name;
    std::vector<RejectedLine> rejected;
    std::string caption;  // along the lower edge
};

/// Writes the frame, enlarged `zoom` times, with what was seen in it as PNG or JPEG.
Result<void> save_corner_overlay(const std::filesystem::path& file, LumaView frame, const CornerOverlay& overlay, int zoom = 1);

}  // namespace roomfix
