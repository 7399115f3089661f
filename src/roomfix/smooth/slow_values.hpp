// Errors that change slowly, as unknowns of the smoother: constant over a while, tied to the next while.
#pragma once

#include <ceres/problem.h>

#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "roomfix/base/time.hpp"
#include "roomfix/estimate/belief.hpp"

namespace roomfix {

/// Errors, in units of their standard deviation, that stay what they are unless somebody moves a camera, a landmark or a corner.
constexpr bool is_lasting(SlowKind kind) { return kind == SlowKind::calibration || kind == SlowKind::landmark_place || kind == SlowKind::corner_place; }

class SlowValues {
public:
    struct Value {
        double* value;
        std::optional<SlowState> state;  // nothing: one of the core's
    };

    /// Values start where `earlier` has them, if it does. `lasting`: what is_lasting() is constant for good. `speed`: m/s, of the robot on average, for what
    /// changes along its way.
    SlowValues(ceres::Problem& problem, Nanoseconds start, bool lasting, double speed, const SlowValues* earlier)
        : problem_(problem), start_(start), lasting_(lasting), speed_(speed), earlier_(earlier) {}

    /// The value of a slow state of the tracker at a time. Ask in the order of times.
    double* of(const SlowState& state, Nanoseconds time);
    /// A value that walks at random: `sigma` at first, and `walk` per square root of a second. `core`: which of the core's states.
    double* walking(int core, double sigma, double walk, Nanoseconds time);

    const std::vector<Value>& all() const { return all_; }

private:
    struct Chain {
        long first = 0;  // number of its first stretch of time
        std::vector<std::unique_ptr<double>> values;
    };
    using Key = std::tuple<int, int, int>;
    double* in_chain(const Key& key, const std::optional<SlowState>& state, double stretch, double sigma, double keep, double step_sigma, Nanoseconds time);

    const double* earlier_value(const Key& key, long number) const;

    ceres::Problem& problem_;
    Nanoseconds start_;
    bool lasting_;
    double speed_;
    const SlowValues* earlier_;
    std::map<Key, Chain> chains_;
    std::vector<Value> all_;
};

}  // namespace roomfix
