// Errors that change slowly, as unknowns of the smoother: constant over a while, tied to the next while.
// Those that are others after a minute or two are constant in a slice of the trajectory, and its unknowns; the rest is common to all slices.
#pragma once

#include <ceres/problem.h>

#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "roomfix/base/time.hpp"
#include "roomfix/estimate/belief.hpp"
#include "roomfix/smooth/slices.hpp"

namespace roomfix {

/// Errors, in units of their standard deviation, that stay what they are unless somebody moves a camera, a landmark or a corner.
constexpr bool is_lasting(SlowKind kind) { return kind == SlowKind::calibration || kind == SlowKind::landmark_place || kind == SlowKind::corner_place; }

/// Does it change so fast, with a robot of that average speed in m/s, that it is an unknown of each slice?
bool changes_fast(const SlowState& state, double speed);

class SlowValues {
public:
    struct Value {
        double* value;
        std::optional<SlowState> state;    // nothing: one of the core's
        std::optional<std::size_t> slice;  // whose unknown it is; nothing: common to all
    };

    /// Values start where `earlier` has them, if it does. `lasting`: what is_lasting() is constant for good. `speed`: m/s, of the robot on average.
    SlowValues(ceres::Problem& problem, Slices slices, bool lasting, double speed, const SlowValues* earlier)
        : problem_(problem), slices_(std::move(slices)), lasting_(lasting), speed_(speed), earlier_(earlier) {}

    /// The value of a slow state of the tracker at a time. Ask in the order of times.
    double* of(const SlowState& state, Nanoseconds time);
    /// A value that walks at random: `sigma` at first, and `walk` per square root of a second. `core`: which of the core's states.
    double* walking(int core, double sigma, double walk, Nanoseconds time);

    /// Adds to a belief what is known of the errors of `source` that all it sees have in common, as they were at a time.
    void add_known(Belief& belief, int source, Nanoseconds time) const;

    const std::vector<Value>& all() const { return all_; }
    const Slices& slices() const { return slices_; }

private:
    struct Chain {
        std::optional<SlowState> state;
        double stretch = 0;  // s, over which each value holds
        long first = 0;      // number of its first stretch of time
        std::vector<std::unique_ptr<double>> values;
    };
    struct FastValue {
        std::size_t slice;
        std::unique_ptr<double> value;
    };
    struct FastChain {
        SlowState state;
        std::vector<FastValue> values;  // in the order of their slices
    };
    using Key = std::tuple<int, int, int>;
    double* in_chain(const Key& key, const std::optional<SlowState>& state, double stretch, double sigma, double keep, double step_sigma, Nanoseconds time);
    double* in_slice(const Key& key, const SlowState& state, Nanoseconds time);

    long number_at(Nanoseconds time, double stretch) const;
    static const double* value_in(const Chain& chain, long number);
    /// Of what changes fast, as it was in the slice of that time.
    const double* value_at(const Key& key, Nanoseconds time) const;

    ceres::Problem& problem_;
    Slices slices_;
    bool lasting_;
    double speed_;
    const SlowValues* earlier_;
    std::map<Key, Chain> chains_;
    std::map<Key, FastChain> fast_;
    std::vector<Value> all_;
};

}  // namespace roomfix
