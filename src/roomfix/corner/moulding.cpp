#include "roomfix/corner/moulding.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr double exactness = 0.002;  // of the edges' rises, ceiling distances

}  // namespace

std::optional<SeenMoulding> moulding_beside(const EdgesBeside& edges, const CornerView& view, double wall_angle) {
    const bool above = edges.above[0] > 0 || edges.above[1] > 0;
    const auto& rises = above ? edges.above : edges.below;
    if (rises[0] == 0 && rises[1] == 0) return std::nullopt;
    // The camera's distances from the walls, in ceiling distances.
    const std::array<double, 2> away = {view.place.y(), view.place.x() * std::sin(wall_angle) - view.place.y() * std::cos(wall_angle)};
    // The moulding's upper edge may lie on the ceiling, as far from the wall as the moulding is high: it then seems to run higher up the wall than it does.
    double least = 0, most = 1e9;
    for (std::size_t i = 0; i < 2; ++i) {
        if (rises[i] == 0) continue;
        least = std::max(least, std::abs(rises[i]) * away[i] / (away[i] + 1 + rises[i]));
        most = std::min(most, std::abs(rises[i]));
    }
    if (least > most) std::swap(least, most);
    SeenMoulding moulding;
    moulding.read = above ? MouldingEdge::lower : MouldingEdge::upper;
    moulding.rise = (above ? 0.5 : -0.5) * (least + most);
    moulding.rise_sigma = (most - least) / std::sqrt(12.0) + exactness;
    moulding.one_wall = rises[0] == 0 || rises[1] == 0;
    return moulding;
}

CornerObservation other_reading(const CornerObservation& seen, const SeenMoulding& moulding) {
    const double scale = 1 / (1 + moulding.rise);
    CornerObservation other = at_distance(seen, 1 + moulding.rise);
    other.part = seen.part == MouldingEdge::lower ? MouldingEdge::upper : MouldingEdge::lower;
    const double spread = moulding.rise_sigma * scale;
    other.covariance.bottomRightCorner<2, 2>() += spread * spread * other.view.place * other.view.place.transpose();
    other.read = false;
    other.other_rise = -moulding.rise * scale;
    other.other_rise_sigma = spread;
    return other;
}

}  // namespace roomfix
