// How often lamps fool the ceiling observer, with a landmark in view and without.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace roomfix {

struct CeilingRobustness {
    int frames = 0;
    int right = 0;  // within 1 cm and 1 deg
    int wrong = 0;  // a fix, but not there; without a landmark every fix is wrong
    int none = 0;
    std::string first_miss;  // what the first frame that was not right looked like
};

/// Frames with a landmark wholly in view and a lit tube anywhere over the robot, in half of them right along the panel's edge; downlights
/// and the LEDs of smoke detectors besides.
CeilingRobustness run_with_lamps(int frames, std::uint64_t seed, const std::function<void(double)>& progress = {});

/// The same without a landmark.
CeilingRobustness run_without_landmark(int frames, std::uint64_t seed, const std::function<void(double)>& progress = {});

}  // namespace roomfix
