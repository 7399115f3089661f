// GOSPA: how far a set of tracks is from the set of true targets, with what is missed and what is false.
// Rahmathullah, Garcia-Fernandez and Svensson, Generalized optimal sub-pattern assignment metric (Fusion 2017), with p = 2 and alpha = 2:
// at one moment, d^2 = min over assignments of (sum of squared distances of the pairs + c^2 / 2 (missed + false)).
#pragma once

#include "roomfix/evaluate/moments.hpp"

namespace roomfix {

struct Gospa {
    std::size_t moments = 0;
    double cutoff = 0;                                    // m: c, where a pair costs as much as a missed target and a false track
    double mean = 0;                                      // m: of d over the moments
    double rms = 0;                                       // m: of d over the moments; its square is the sum of the squares of the three parts
    double localisation = 0, missed = 0, false_ones = 0;  // m
    double missed_at_once = 0, false_at_once = 0;         // how many at a moment, on average
};

/// The pairs that GOSPA makes at one moment.
std::vector<CloseBy> gospa_pairs(const Moments& moments, const Moment& moment);

Gospa gospa_of(const Moments& moments);

}  // namespace roomfix
