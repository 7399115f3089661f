// What was there and what was reported at one moment after the other: on this rest all figures for several targets.
#pragma once

#include <string>
#include <vector>

#include "roomfix/base/assignment.hpp"
#include "roomfix/evaluate/truth.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix {

/// A true target and a track that may belong together.
struct CloseBy {
    int target = 0, track = 0;
    double distance = 0;  // m
};

struct Moment {
    Nanoseconds time = 0;
    std::vector<int> targets, tracks;  // those that are there
    std::vector<CloseBy> pairs;        // up to the cut-off apart
};

struct Moments {
    double cutoff = 0;                         // m
    std::vector<std::string> targets, tracks;  // names, by number
    std::vector<Moment> all;                   // in the order of their times
};

/// All times at which the truth says anything, each once.
std::vector<Nanoseconds> times_of(const Truth& truth);

/// At each time, the targets whose place is known, and of each name the newest fix that is not older than `fresh` (s) and that a later fix of status
/// none has not ended. A fix is as far from a target as it was at the fix's own time, so that its age is no error. Fixes without a name are left out.
/// `fixes`: in the order of their times.
Moments moments_of(const std::vector<Fix>& fixes, const Truth& truth, const std::vector<Nanoseconds>& times, double cutoff, double fresh);

/// The pairs of one moment, each target and each track in one at most, with the least sum of `cost` where a target without a pair costs `alone`.
template <class Cost>
std::vector<CloseBy> best_pairs(const Moments& moments, const Moment& moment, double alone, const Cost& cost) {
    std::vector<PossiblePair> possible;
    for (const CloseBy& pair : moment.pairs) {
        if (const double value = cost(pair); value < alone) possible.push_back({pair.target, pair.track, value});
    }
    std::vector<CloseBy> chosen;
    if (possible.empty()) return chosen;
    const std::vector<int> track_of = assign(static_cast<int>(moments.targets.size()), static_cast<int>(moments.tracks.size()), possible, alone);
    for (const CloseBy& pair : moment.pairs) {
        if (track_of[static_cast<std::size_t>(pair.target)] == pair.track) chosen.push_back(pair);
    }
    return chosen;
}

}  // namespace roomfix
