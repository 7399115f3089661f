// Collects the moments from which a robot's body is learned: what fixed cameras show of it, at evenly spread times of a recording.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "roomfix/calibrate/body_learner.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct RobotSessionOptions {
    std::vector<std::string> cameras;     // whose pictures are used; empty: all fixed ones
    std::vector<std::string> pictures;    // of the only camera, each a moment; empty: the cameras' sources
    std::vector<std::string> background;  // for all cameras; empty: as the site file says, or else the pictures themselves
    std::size_t most_frames = 64;         // of all cameras together
};

/// Views and evidence of the moments, which point into them.
class RobotSession {
public:
    static Result<RobotSession> collect(const Site& site, const RobotSessionOptions& options, const std::atomic<bool>& stop,
                                        const std::function<void(double)>& progress = {});

    const std::vector<BodyMoment>& moments() const { return moments_; }
    const std::vector<std::string>& names() const { return names_; }      // of each moment's first frame
    const std::vector<std::string>& cameras() const { return cameras_; }  // used
    std::size_t frames() const { return evidence_.size(); }

private:
    std::vector<std::unique_ptr<View>> views_;
    std::vector<std::unique_ptr<Evidence>> evidence_;
    std::vector<BodyMoment> moments_;
    std::vector<std::string> names_;
    std::vector<std::string> cameras_;
};

}  // namespace roomfix
