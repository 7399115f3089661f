// How exactly a fixed camera tells where something stands on the floor that it sees.
#pragma once

#include <vector>

#include "roomfix/geometry/view.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct ErrorCell {
    Eigen::Vector2d centre;  // m, map
    double radius = 0;       // m: longer half axis of the 95 % ellipse
};

struct ErrorMap {
    double cell = 0.15;  // m, edge of a cell
    std::vector<ErrorCell> cells;
};

/// What the camera's calibration and a reading error of `reading_sigma` px add up to, over the floor that is in sight and no farther than
/// `farthest` m. Cells get larger where there would be more than `most`.
ErrorMap error_map(const View& view, const std::vector<Polyline>& walls, double farthest, double reading_sigma = 0.3, std::size_t most = 3000);

}  // namespace roomfix
