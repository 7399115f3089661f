// Which way a learned body lies in its own frame: robots are alike left and right.
#pragma once

#include <vector>

#include "roomfix/site/learned_body.hpp"

namespace roomfix {

/// A line in the robot's ground plane.
struct GroundLine {
    double angle = 0;   // rad, of its direction
    double offset = 0;  // m, to the left of the origin, seen along it
};

/// The box around a footprint that lies along a line at `angle` (rad): m, its x axis along that line.
struct FootprintBox {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = Eigen::Vector2d::Constant(-1e9);

    double area() const { return (high - low).prod(); }
    Eigen::Vector2d middle() const { return 0.5 * (low + high); }
};
FootprintBox footprint_box(const std::vector<ConvexPart>& parts, double angle);

/// The line along which a body lies, within an eighth of a turn of the x axis: along which the box around its footprint is smallest, and about which its look
/// is most like its own mirror image, each as far as it tells. `reach`: m, how far beside the origin the line may lie.
GroundLine body_axis(const std::vector<ConvexPart>& parts, const BodyLook& look, double reach);

}  // namespace roomfix
