// Who was found, who was missed, and what was nobody: for several targets that look alike.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace roomfix {

struct DetectionCount {
    int listed = 0;  // targets that were there
    int found = 0;
    int missed = 0;
    int false_ones = 0;          // detections that are no listed target
    std::vector<double> errors;  // m, of the found ones
};

/// Adds one frame: matches detections and targets (m, on the floor) one to one, nearest pairs first, up to `gate` m apart.
void count_frame(const std::vector<Eigen::Vector2d>& targets, const std::vector<Eigen::Vector2d>& detections, double gate, DetectionCount& count);

}  // namespace roomfix
