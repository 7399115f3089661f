// Long edges of light in a picture, followed point by point.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct LongEdgeSettings {
    double least_length = 0.18;  // of the picture's width: shorter edges say too little
    double largest_turn = 0.5;   // rad along an edge: more is no straight edge behind any lens
};

constexpr std::size_t least_edge_points = 12;

/// An edge that was followed through a picture, px.
struct LongEdge {
    std::vector<Eigen::Vector2d> points;  // in their order
    std::size_t picture = 0;              // among those of the calibration
    bool used = true;                     // it is straight in truth, as far as one can tell
};

/// All long edges of a picture, subpixel. `number`: of the picture.
std::vector<LongEdge> long_edges(LumaView picture, std::size_t number, const LongEdgeSettings& settings = {});

/// The longest first, and without those that a longer one of another picture covers: the same edge in several pictures of a camera that stands still says no
/// more than once.
std::vector<LongEdge> without_repeats(std::vector<LongEdge> edges);

}  // namespace roomfix
