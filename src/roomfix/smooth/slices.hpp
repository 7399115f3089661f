// A trajectory in slices of time so short that errors which change fast are constant within each.
#pragma once

#include <cstddef>
#include <vector>

#include "roomfix/smooth/trajectory.hpp"

namespace roomfix {

constexpr double part_of_memory = 0.2;  // of the time or way over which an error becomes another: so long it may be taken for constant

/// m, from the first knot to each, by the places a second apart: what trembles within a second is no way.
std::vector<double> way_along(const Trajectory& trajectory);

/// How fast an error becomes another one.
struct ChangeRate {
    double per_second = 0;  // 1/s
    double per_metre = 0;   // 1/m, along the robot's way
};

class Slices {
public:
    /// Each slice is over before more than `part_of_memory` of an error that changes so fast has passed, but holds a knot at least.
    /// Where nothing changes fast each knot is a slice of its own.
    Slices(const Trajectory& trajectory, const ChangeRate& fastest);

    std::size_t size() const { return first_knots_.size(); }
    /// Its first knot.
    std::size_t first_knot(std::size_t slice) const { return first_knots_[slice]; }
    Nanoseconds start(std::size_t slice) const { return starts_[slice]; }
    /// The slice of a time; the first or the last one before or after all of them.
    std::size_t at(Nanoseconds time) const;
    /// How old an error grows from the start of one slice to that of a later one: 1 where it has forgotten all but 1/e.
    double age(std::size_t from, std::size_t to, const ChangeRate& rate) const;

private:
    std::vector<std::size_t> first_knots_;
    std::vector<Nanoseconds> starts_;
    std::vector<double> metres_;  // at the start of each slice
};

}  // namespace roomfix
