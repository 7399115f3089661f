#include "roomfix/observation/corner_observation.hpp"

#include <cmath>

namespace roomfix {
namespace {

constexpr double lower_if_alone = 0.8;  // that edges are a moulding's lower ones where no others are seen: white plaster hardly shows below a white ceiling
constexpr double measured = 0.015;      // m: the moulding's height is stated about as exactly as this

}  // namespace

FixedList<DepthBelowCeiling, 2> depths_of(const CornerObservation& seen, double moulding, double distance) {
    FixedList<DepthBelowCeiling, 2> depths;
    if (moulding <= 0) {
        depths.push_back({0, 1});
        return depths;
    }
    const bool lower = seen.part == MouldingEdge::lower;
    const double scale = lower ? distance - moulding : distance;
    const double off = std::abs(seen.other_rise) * scale - moulding;
    const bool is_it = seen.part != MouldingEdge::none_seen && std::abs(off) < 3 * seen.other_rise_sigma * scale + measured;
    if (is_it) {
        depths.push_back({lower ? moulding : 0, 1});
        return depths;
    }
    depths.push_back({moulding, lower_if_alone});
    depths.push_back({0, 1 - lower_if_alone});
    return depths;
}

}  // namespace roomfix
