#include "roomfix/estimate/range_stretch.hpp"

#include <cmath>
#include <optional>
#include <utility>

namespace roomfix {
namespace {

// Components of the dependence on the direction.
constexpr int ahead = 0, to_the_left = 1;

}  // namespace

void add_slow_states(Belief& belief, int source, const StretchErrors& errors, double forget) {
    if (errors.scale > 0) ensure_slow(belief, {SlowKind::range_scale, source, 0, errors.scale * errors.scale, forget});
    // A sensor's characteristic stays what it is.
    if (errors.curve > 0) ensure_slow(belief, {SlowKind::range_curve, source, 0, errors.curve * errors.curve});
    if (errors.direction <= 0) return;
    for (const int component : {ahead, to_the_left}) {
        ensure_slow(belief, {SlowKind::range_direction, source, component, errors.direction * errors.direction, forget});
    }
}

/// range (1 + scale) (1 + (depth + a) (cos(bearing) - 1) + b sin(bearing)) + curve range^2
StretchedRange stretched(const Belief& belief, int source, const StretchErrors& errors, double range, double bearing) {
    const double s = std::sin(bearing), less = std::cos(bearing) - 1;
    const auto value_of = [&](SlowKind kind, int component, double sigma) -> std::pair<std::optional<int>, double> {
        const auto state = sigma > 0 ? find_slow(belief, kind, source, component) : std::nullopt;
        return {state, state ? belief.mean[*state] : 0};
    };
    const auto [scale_state, longer] = value_of(SlowKind::range_scale, 0, errors.scale);
    const auto [ahead_state, more] = value_of(SlowKind::range_direction, ahead, errors.direction);
    const auto [left_state, b] = value_of(SlowKind::range_direction, to_the_left, errors.direction);
    const auto [curve_state, curve] = value_of(SlowKind::range_curve, 0, errors.curve);
    const double scale = 1 + longer, a = errors.depth + more;
    const double turned = 1 + a * less + b * s;
    StretchedRange result;
    result.by_range = scale * turned + 2 * curve * range;
    result.value = scale * turned * range + curve * range * range;
    result.by_bearing = scale * range * (b * (less + 1) - a * s);
    const auto depends = [&](const std::optional<int>& state, double sigma, double derivative) {
        if (!state) {
            result.noise += sigma * sigma * derivative * derivative;
            return;
        }
        result.by_state[result.states.size()] = derivative;
        result.states.push_back(*state);
    };
    depends(scale_state, errors.scale, range * turned);
    depends(ahead_state, errors.direction, scale * range * less);
    depends(left_state, errors.direction, scale * range * s);
    depends(curve_state, errors.curve, range * range);
    return result;
}

}  // namespace roomfix
