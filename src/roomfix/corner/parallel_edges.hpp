// A moulding under the ceiling draws several parallel edges on each wall: which of them meets the end of the edge between the walls?
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "roomfix/corner/corner_fit.hpp"

namespace roomfix {

struct ParallelSettings {
    double above = 0.06, below = 0.06;  // of the picture's height: corners this far up and down the walls' edge are tried
    double cell = 0.5;                  // px, at the corner
    double plain = 4;                   // standard deviations that a step stands out
    double least = 0.5;                 // of the best corner's votes that make another one
    // An edge beside the x or the y edge belongs to a moulding if it keeps beside it. Lengths in px at 640 px of width.
    double apart = 4;     // px: nearer ones are one edge
    double near = 70;     // px from the corner: here ...
    double far = 220;     // ... and up to here ...
    double kept = 0.6;    // ... it is seen along this part,
    double second = 0.4;  // or along this if the other wall shows one about as high
};

/// A corner with the same directions of its edges, a little up or down the walls' edge.
struct ParallelCorner {
    double rise = 0;   // of the corner above the fit's, in units of its ceiling distance
    double votes = 0;  // px of the x and of the y edge that have a step there, the smaller of the two
};

/// All corners that the light around the fit's x and y edges allows, from the lowest to the highest. `fit.pieces` must hold wide profiles.
void find_parallel_corners(const CornerFit& fit, double height, const ParallelSettings& settings, std::vector<ParallelCorner>& corners);

/// The outermost edges that keep above and below the fit's x and y edges from the corner on, as a moulding's do: how much higher or lower they run, in
/// ceiling distances; 0: there is none.
struct EdgesBeside {
    std::array<double, 2> above = {0, 0}, below = {0, 0};
};

/// What the light around the x and y edges says of edges beside them, gathered from fits that are raised by more and more.
class BesideVotes {
public:
    static constexpr double step = 24;  // px at the corner: rises are this far apart
    static constexpr int most = 2;      // of them each way

    /// `lift`: px by which a rise of one ceiling distance moves the x and the y edge beside the corner; `unit`: px at 640 px of width.
    BesideVotes(const std::array<double, 2>& lift, double unit, const ParallelSettings& settings);
    /// The rise of the `k`-th fit, -most to most.
    double rise(int k) const { return k * rise_step_; }
    /// `fit`: raised by rise(k); its pieces must hold wide profiles.
    void add(const CornerFit& fit, int k);
    EdgesBeside found() const;

private:
    static constexpr int reach = 64;  // cells of a px each way
    static constexpr int cells = 2 * reach + 1;
    struct Row {
        std::array<double, cells> near{}, all{};  // px along which there is a step
    };
    struct Length {
        double near = 0, all = 0;  // px that could be read
    };
    bool holds(std::size_t edge, int cell, double part) const;
    double outermost(std::size_t edge, int direction, double part, double from, double to) const;

    ParallelSettings settings_;
    std::array<double, 2> lift_;
    double unit_;
    double rise_step_;
    std::array<std::array<Row, 2>, 2> votes_{};  // by edge and the sign of the step
    std::array<std::array<Length, 2 * most + 1>, 2> read_{};
};

/// The same camera, and the same edges' directions, for a corner that lies `rise` higher.
CornerView with_corner_raised(const CornerView& view, double rise);

/// How much higher a corner straight above or below the view's own lies that is seen at `point` of the plane at distance 1 before the camera.
double rise_of_corner_at(const CornerView& view, const Eigen::Vector2d& point);

/// How far `lower`'s corner lies below `upper`'s along the walls' edge, px; nothing where no moulding of `largest` times the picture's height puts it there.
std::optional<double> moulding_between(const CameraModel& model, const CornerView& upper, const CornerView& lower, double wall_angle, double largest);

}  // namespace roomfix
