// A moulding under the ceiling draws several parallel edges on each wall: which of them meets the end of the edge between the walls?
#pragma once

#include <optional>
#include <vector>

#include "roomfix/corner/corner_fit.hpp"

namespace roomfix {

struct ParallelSettings {
    double above = 0.06, below = 0.06;  // of the picture's height: corners this far up and down the walls' edge are tried
    double cell = 0.5;                  // px, at the corner
    double plain = 4;                   // standard deviations that a step stands out
    double least = 0.5;                 // of the best corner's votes that make another one
};

/// A corner with the same directions of its edges, a little up or down the walls' edge.
struct ParallelCorner {
    double rise = 0;   // of the corner above the fit's, in units of its ceiling distance
    double votes = 0;  // px of the x and of the y edge that have a step there, the smaller of the two
};

/// All corners that the light around the fit's x and y edges allows, from the lowest to the highest. `fit.pieces` must hold wide profiles.
void find_parallel_corners(const CornerFit& fit, double height, const ParallelSettings& settings, std::vector<ParallelCorner>& corners);

/// The same camera, and the same edges' directions, for a corner that lies `rise` higher.
CornerView with_corner_raised(const CornerView& view, double rise);

/// How much higher a corner straight above or below the view's own lies that is seen at `point` of the plane at distance 1 before the camera.
double rise_of_corner_at(const CornerView& view, const Eigen::Vector2d& point);

/// How far `lower`'s corner lies below `upper`'s along the walls' edge, px; nothing where no moulding of `largest` times the picture's height puts it there.
std::optional<double> moulding_between(const CameraModel& model, const CornerView& upper, const CornerView& lower, double wall_angle, double largest);

}  // namespace roomfix
