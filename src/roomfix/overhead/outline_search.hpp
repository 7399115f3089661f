// Poses whose outline runs along the foreground's border: for robots that are partly hidden, cut off or merged, where the
// foreground's area misleads.
#pragma once

#include <vector>

#include "roomfix/overhead/foreground_border.hpp"
#include "roomfix/overhead/robot_search.hpp"

namespace roomfix {

/// An outline with its part that lies on the border.
struct OutlineStart {
    Pose2 pose;
    double support = 0;  // 0..1 of all of the outline
};

/// The best poses on a stretch of floor, by the outline's support, best first, not twice the same. At most `most`.
void search_outline(const BorderDistance& border, const View& view, const ShapePoints& shape, const FloorRectangle& floor, std::size_t most,
                    std::vector<OutlineStart>& found);

}  // namespace roomfix
