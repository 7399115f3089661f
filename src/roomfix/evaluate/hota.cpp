#include "roomfix/evaluate/hota.hpp"

#include <cmath>
#include <map>

namespace roomfix {
namespace {

constexpr int thresholds = 19;     // 1/20 apart
constexpr double rounding = 1e-9;  // of a similarity

using Pair = std::pair<int, int>;  // target, track

/// How many places each target and each track has.
struct Counts {
    std::vector<std::size_t> target, track;
    std::size_t targets = 0, tracks = 0;

    explicit Counts(const Moments& moments) : target(moments.targets.size(), 0), track(moments.tracks.size(), 0) {
        for (const Moment& moment : moments.all) {
            for (const int t : moment.targets) ++target[static_cast<std::size_t>(t)];
            for (const int t : moment.tracks) ++track[static_cast<std::size_t>(t)];
            targets += moment.targets.size();
            tracks += moment.tracks.size();
        }
    }
    /// TPA / (TPA + FNA + FPA) of a target and a track that are `together` so often.
    double association(const Pair& pair, double together) const {
        return together / (static_cast<double>(target[static_cast<std::size_t>(pair.first)] + track[static_cast<std::size_t>(pair.second)]) - together);
    }
};

double similarity(const Moments& moments, const CloseBy& pair) { return 1 - pair.distance / moments.cutoff; }

/// How often a target and a track could be together; a moment at which others are as near counts less.
std::map<Pair, double> possibly_together(const Moments& moments) {
    std::map<Pair, double> together;
    for (const Moment& moment : moments.all) {
        std::map<int, double> of_target, of_track;
        for (const CloseBy& pair : moment.pairs) {
            of_target[pair.target] += similarity(moments, pair);
            of_track[pair.track] += similarity(moments, pair);
        }
        for (const CloseBy& pair : moment.pairs) {
            const double own = similarity(moments, pair), all = of_target[pair.target] + of_track[pair.track] - own;
            together[{pair.target, pair.track}] += all > 0 ? own / all : 0;
        }
    }
    return together;
}

/// The pairs of all moments: near ones that are also together for long.
std::vector<CloseBy> matched_pairs(const Moments& moments, const Counts& counts) {
    const std::map<Pair, double> together = possibly_together(moments);
    const auto cost = [&](const CloseBy& pair) {
        const Pair both(pair.target, pair.track);
        return -similarity(moments, pair) * counts.association(both, together.at(both));
    };
    std::vector<CloseBy> all;
    for (const Moment& moment : moments.all) {
        const auto pairs = best_pairs(moments, moment, 0, cost);
        all.insert(all.end(), pairs.begin(), pairs.end());
    }
    return all;
}

Hota hota_at(double alpha, const Moments& moments, const std::vector<CloseBy>& matched, const Counts& counts) {
    std::map<Pair, std::size_t> together;
    std::size_t pairs = 0;
    for (const CloseBy& pair : matched) {
        if (similarity(moments, pair) < alpha - rounding) continue;
        ++together[{pair.target, pair.track}];
        ++pairs;
    }
    if (pairs == 0) return {};
    Hota at;
    at.detection = static_cast<double>(pairs) / static_cast<double>(counts.targets + counts.tracks - pairs);
    for (const auto& [pair, count] : together) at.association += static_cast<double>(count) * counts.association(pair, static_cast<double>(count));
    at.association /= static_cast<double>(pairs);
    at.hota = std::sqrt(at.detection * at.association);
    return at;
}

}  // namespace

Hota hota_of(const Moments& moments) {
    const Counts counts(moments);
    const std::vector<CloseBy> matched = matched_pairs(moments, counts);
    Hota mean;
    for (int threshold = 1; threshold <= thresholds; ++threshold) {
        const Hota at = hota_at(threshold / (thresholds + 1.0), moments, matched, counts);
        mean.hota += at.hota / thresholds;
        mean.detection += at.detection / thresholds;
        mean.association += at.association / thresholds;
    }
    return mean;
}

}  // namespace roomfix
