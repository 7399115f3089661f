// Upright parts of a body: an outline from above between two heights.
#pragma once

#include <vector>

#include "roomfix/site/site.hpp"

namespace roomfix {

struct Prism {
    std::vector<Eigen::Vector2d> hull;  // m, counter-clockwise
    double low = 1e9, high = -1e9;      // m
};

/// The upright prism around a part.
Prism prism_of(const ConvexPart& part);

}  // namespace roomfix
