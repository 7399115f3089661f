#include "roomfix/evaluate/idf1.hpp"

#include <map>

namespace roomfix {

IdentityScore identity_score(const Moments& moments) {
    std::map<std::pair<int, int>, std::size_t> together;  // moments at which a target and a track agree
    std::size_t targets = 0, tracks = 0;
    for (const Moment& moment : moments.all) {
        targets += moment.targets.size();
        tracks += moment.tracks.size();
        for (const CloseBy& pair : moment.pairs) ++together[{pair.target, pair.track}];
    }
    // Least false positives and false negatives are most true positives, since each of these is one less of both.
    std::vector<PossiblePair> possible;
    for (const auto& [pair, count] : together) possible.push_back({pair.first, pair.second, -static_cast<double>(count)});
    const std::vector<int> track_of = assign(static_cast<int>(moments.targets.size()), static_cast<int>(moments.tracks.size()), possible, 0);
    IdentityScore score;
    for (const auto& [pair, count] : together) {
        if (track_of[static_cast<std::size_t>(pair.first)] == pair.second) score.true_positives += count;
    }
    score.false_positives = tracks - score.true_positives;
    score.false_negatives = targets - score.true_positives;
    return score;
}

}  // namespace roomfix
