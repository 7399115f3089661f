#include "roomfix/estimate/range_stretch.hpp"

#include <cmath>

namespace roomfix {
namespace {

// Components of the dependence on the direction.
constexpr int ahead = 0, to_the_left = 1;

}  // namespace

void add_slow_states(Belief& belief, int source, const StretchErrors& errors, double forget) {
    if (errors.scale > 0) ensure_slow(belief, {SlowKind::range_scale, source, 0, errors.scale * errors.scale, forget});
    if (errors.direction <= 0) return;
    for (const int component : {ahead, to_the_left}) {
        ensure_slow(belief, {SlowKind::range_direction, source, component, errors.direction * errors.direction, forget});
    }
}

/// range (1 + scale) (1 + (depth + a) (cos(bearing) - 1) + b sin(bearing))
StretchedRange stretched(const Belief& belief, int source, const StretchErrors& errors, double range, double bearing) {
    const double s = std::sin(bearing), less = std::cos(bearing) - 1;
    StretchedRange result;
    const auto value_of = [&](SlowKind kind, int component, double sigma, double derivative) {
        if (sigma <= 0) return 0.0;
        const auto state = find_slow(belief, kind, source, component);
        if (!state) {
            result.noise += sigma * sigma * derivative * derivative;
            return 0.0;
        }
        result.by_state[result.states.size()] = derivative;
        result.states.push_back(*state);
        return belief.mean[*state];
    };
    const double scale = 1 + value_of(SlowKind::range_scale, 0, errors.scale, range);
    const double a = errors.depth + value_of(SlowKind::range_direction, ahead, errors.direction, range * less);
    const double b = value_of(SlowKind::range_direction, to_the_left, errors.direction, range * s);
    const double turned = 1 + a * less + b * s;
    result.by_range = scale * turned;
    result.value = result.by_range * range;
    result.by_bearing = scale * range * (b * (less + 1) - a * s);
    return result;
}

}  // namespace roomfix
