// A corner that stands out into the room, such as a cupboard's seen from above, draws the same three lines as the room's own: which is it?
#pragma once

#include <vector>

#include "roomfix/corner/corner_geometry.hpp"
#include "roomfix/corner/line_search.hpp"
#include "roomfix/geometry/camera_model.hpp"

namespace roomfix {

struct OutsideCornerSettings {
    double least_length = 48;   // px at 640 px of width: only lines this long ...
    double density = 0.6;       // ... and this plain are asked; what stains and grain draw is not
    double tolerance = 0.02;    // rad: a line runs along a direction within this, for edges of small things are not exact ...
    double clearly = 4;         // ... if it is so many times farther from all directions of the other explanation
    double end_error = 0.7;     // px over its length: no line is known better
    double near_corner = 0.05;  // rad: lines that pass the corner this closely run much the same way for both
};

/// Px of the other lines of the picture that run along one of the corner's edges, if it is a corner of the room, and if it stands out.
/// Lines that fit both ways, or neither, are left out.
struct CornerCompanions {
    double inside = 0, outside = 0;
};

/// Three lines from a common point are the picture of two corners, each the other's mirror picture in depth (Necker's cube). Walls, doors,
/// pictures and furniture mostly run along the directions of the one that is there.
CornerCompanions companions_of(const CornerView& view, double wall_angle, const std::vector<SceneLine>& lines, const CameraModel& model,
                               const OutsideCornerSettings& settings = {});

}  // namespace roomfix
