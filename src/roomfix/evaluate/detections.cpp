#include "roomfix/evaluate/detections.hpp"

#include <algorithm>

namespace roomfix {

void count_frame(const std::vector<Eigen::Vector2d>& targets, const std::vector<Eigen::Vector2d>& detections, double gate, DetectionCount& count) {
    struct Pair {
        double distance;
        std::size_t target, detection;
    };
    std::vector<Pair> pairs;
    for (std::size_t t = 0; t < targets.size(); ++t) {
        for (std::size_t d = 0; d < detections.size(); ++d) {
            const double distance = (targets[t] - detections[d]).norm();
            if (distance <= gate) pairs.push_back({distance, t, d});
        }
    }
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
    std::vector<bool> target_used(targets.size(), false);
    std::vector<bool> detection_used(detections.size(), false);
    int found = 0;
    for (const Pair& pair : pairs) {
        if (target_used[pair.target] || detection_used[pair.detection]) continue;
        target_used[pair.target] = detection_used[pair.detection] = true;
        count.errors.push_back(pair.distance);
        ++found;
    }
    count.listed += static_cast<int>(targets.size());
    count.found += found;
    count.missed += static_cast<int>(targets.size()) - found;
    count.false_ones += static_cast<int>(detections.size()) - found;
}

}  // namespace roomfix
