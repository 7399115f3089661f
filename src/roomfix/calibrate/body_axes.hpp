// Which way a learned body lies in its own frame: robots are alike left and right.
#pragma once

#include <optional>
#include <vector>

#include "roomfix/site/learned_body.hpp"

namespace roomfix {

/// A line in the robot's ground plane.
struct GroundLine {
    double angle = 0;   // rad, of its direction
    double offset = 0;  // m, to the left of the origin, seen along it
};

/// By how much to turn a body (rad, up to an eighth of a turn) so that the box around it along the axes is smallest.
double crookedness(const std::vector<ConvexPart>& parts);

/// The line about which the look is most like its own mirror image, within an eighth of a turn of the x axis and `reach` (m) of the
/// origin; nothing where no line is much better than the others.
std::optional<GroundLine> mirror_line(const BodyLook& look, double reach);

}  // namespace roomfix
