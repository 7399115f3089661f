// Where lamps are in a picture, for showing what was rejected.
#pragma once

#include <vector>

#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// px, inclusive
struct LampBox {
    int left, top, right, bottom;
};

/// Bright areas (at least `threshold`) of `least_area` pixels and more. Not for every frame: it walks over all pixels one by one.
std::vector<LampBox> find_lamps(LumaView frame, int threshold = 200, int least_area = 60);

}  // namespace roomfix
