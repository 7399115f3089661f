// AprilTags painted into a picture.
#pragma once

#include <cstdint>

#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// Paints a tag with its white border where the view sees it, blurred by about a pixel, with noise (grey levels). From behind it is not
/// seen. `index` picks the noise.
void paint_tag(const View& view, const Eigen::Isometry3d& map_from_tag, const Tag& tag, double noise, std::uint64_t index, LumaImage& frame);

}  // namespace roomfix
