// People and other things that are no robots of the site: were they found, and was a robot put on one of them?
#pragma once

#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/moments.hpp"

namespace roomfix {

struct UnknownThings {
    bool in_truth = false;
    std::size_t fixes = 0;          // of unknown things
    std::size_t listed = 0;         // true things at moments
    std::size_t found = 0;          // of these: with a fix within the cut-off
    Summary error;                  // m, of the found ones
    std::size_t false_ones = 0;     // stretches in which a fix's thing is none, each counted where it begins
    double minutes = 0;             // of the truth
    std::size_t robot_fixes = 0;    // fixes of robots of status ok that were compared with the things
    std::size_t robots_on_one = 0;  // of these: they stand on a thing and not on their robot

    double found_part() const { return listed > 0 ? static_cast<double>(found) / static_cast<double>(listed) : 0; }
    double false_per_minute() const { return minutes > 0 ? static_cast<double>(false_ones) / minutes : 0; }
    double robots_on_one_part() const { return robot_fixes > 0 ? static_cast<double>(robots_on_one) / static_cast<double>(robot_fixes) : 0; }
};

/// The fixes of unknown things beside the true ones at the given times, by the pairs that GOSPA makes.
UnknownThings judge_things(const std::vector<Fix>& fixes, const Truth& things, const std::vector<Nanoseconds>& times, double cutoff, double fresh);

/// Counts a robot's fix of status ok, and whether it stands on one of `things`: nearer to it than `near` (m) and `away` from its own robot.
void count_on_thing(const Fix& fix, bool away, const Truth& things, double near, UnknownThings& count);

}  // namespace roomfix
