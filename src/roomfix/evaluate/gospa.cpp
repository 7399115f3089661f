#include "roomfix/evaluate/gospa.hpp"

#include <cmath>

namespace roomfix {

std::vector<CloseBy> gospa_pairs(const Moments& moments, const Moment& moment) {
    // Without a pair, a target costs c^2 / 2 and so does the track that it leaves alone.
    return best_pairs(moments, moment, moments.cutoff * moments.cutoff, [](const CloseBy& pair) { return pair.distance * pair.distance; });
}

Gospa gospa_of(const Moments& moments) {
    Gospa gospa;
    gospa.moments = moments.all.size();
    gospa.cutoff = moments.cutoff;
    if (moments.all.empty()) return gospa;
    const double squared_cutoff = moments.cutoff * moments.cutoff;
    double squares = 0;  // m^2: of the pairs
    std::size_t missed = 0, false_ones = 0;
    for (const Moment& moment : moments.all) {
        const auto pairs = gospa_pairs(moments, moment);
        double localisation = 0;
        for (const CloseBy& pair : pairs) localisation += pair.distance * pair.distance;
        const std::size_t missed_now = moment.targets.size() - pairs.size(), false_now = moment.tracks.size() - pairs.size();
        gospa.mean += std::sqrt(localisation + squared_cutoff / 2 * static_cast<double>(missed_now + false_now));
        squares += localisation;
        missed += missed_now;
        false_ones += false_now;
    }
    const auto count = static_cast<double>(moments.all.size());
    gospa.mean /= count;
    gospa.missed_at_once = static_cast<double>(missed) / count;
    gospa.false_at_once = static_cast<double>(false_ones) / count;
    gospa.localisation = std::sqrt(squares / count);
    gospa.missed = std::sqrt(squared_cutoff / 2 * gospa.missed_at_once);
    gospa.false_ones = std::sqrt(squared_cutoff / 2 * gospa.false_at_once);
    gospa.rms = std::hypot(gospa.localisation, gospa.missed, gospa.false_ones);
    return gospa;
}

}  // namespace roomfix
