// A camera's picture with what was found drawn on it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/bit_mask.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/observation/silhouette_observation.hpp"

namespace roomfix {

struct OverlayOptions {
    const BitMask* foreground = nullptr;  // tinted if given
    int zoom = 1;
    int crop_x = 0, crop_y = 0, crop_width = 0, crop_height = 0;  // 0: the whole picture
};

/// Writes the frame with each robot's outline, its heading on the floor and a label as PNG or JPEG. `labels` has one text
/// per observation.
Result<void> save_overlay(const std::filesystem::path& file, LumaView frame, const View& view, const std::vector<SilhouetteObservation>& observations,
                          const std::vector<std::string>& labels, const OverlayOptions& options = {});

}  // namespace roomfix
