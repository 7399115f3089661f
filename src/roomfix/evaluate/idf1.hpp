// IDF1: how much of the time each target goes by one name, the same for the whole session.
// Ristani, Solera, Zou, Cucchiara and Tomasi, Performance measures and a data set for multi-target, multi-camera tracking (ECCV 2016 workshops).
#pragma once

#include "roomfix/evaluate/moments.hpp"

namespace roomfix {

/// Targets are assigned to names once for all moments, so that as many places as possible agree within the cut-off.
struct IdentityScore {
    std::size_t true_positives = 0, false_positives = 0, false_negatives = 0;  // IDTP, IDFP, IDFN: places at moments

    double precision() const { return part(true_positives, true_positives + false_positives); }                     // IDP
    double recall() const { return part(true_positives, true_positives + false_negatives); }                        // IDR
    double f1() const { return part(2 * true_positives, 2 * true_positives + false_positives + false_negatives); }  // IDF1
    static double part(std::size_t of, std::size_t all) { return all > 0 ? static_cast<double>(of) / static_cast<double>(all) : 0; }
};

IdentityScore identity_score(const Moments& moments);

}  // namespace roomfix
