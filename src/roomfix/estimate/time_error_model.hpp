// What the wrong time of a camera's frame does to what was seen in it.
#pragma once

#include <algorithm>

#include "roomfix/estimate/update.hpp"
#include "roomfix/observation/time_error.hpp"

namespace roomfix {

/// s, 1 sigma. `stated`: of the camera, by the site.
inline double time_sigma(double stated, const TimeError& error) { return std::max(stated, error.sigma); }

/// Prepares the slow state of the frame's time, in standard deviations; nothing where the time is right.
inline void add_time_error(Belief& belief, int source, double stated, const TimeError& error) {
    constexpr double forget = 1e-3;  // 1/s
    if (time_sigma(stated, error) > 0) ensure_slow(belief, {SlowKind::time_offset, source, error.way, 1, forget});
}

/// `by_time`: how the measurement moves with the time, 1/s.
template <int Rows>
void depends_on_time(Linearised<Rows>& l, const Belief& belief, int source, double stated, const TimeError& error,
                     const Eigen::Matrix<double, Rows, 1>& by_time) {
    if (const auto slow = find_slow(belief, SlowKind::time_offset, source, error.way)) l.depends_on_slow(belief, *slow, time_sigma(stated, error) * by_time);
}

}  // namespace roomfix
