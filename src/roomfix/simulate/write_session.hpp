// A scenario rendered into a session folder.
#pragma once

#include <filesystem>
#include <functional>

#include "roomfix/base/result.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {

struct SessionOptions {
    double duration = 0;         // s; 0: the scenario's own
    int background_frames = 30;  // empty frames per camera, in background/CAMERA
    bool png = false;            // lossless, larger; otherwise JPEG
    std::uint64_t seed = 1;      // of noise and light
};

/// Writes site.yaml, frames/CAMERA/NANOSECONDS.jpg, background/CAMERA/..., truth.csv. The folder must not hold a session
/// already. Same scenario and seed, same bytes. `progress` gets values from 0 to 1.
Result<void> write_session(const Scenario& scenario, const std::filesystem::path& folder, const SessionOptions& options,
                           const std::function<void(double)>& progress = {});

}  // namespace roomfix
