// What the cameras of a moment see that nothing explains yet.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "roomfix/overhead/place_score.hpp"

namespace roomfix {

struct StandingBody {
    const Body* body = nullptr;
    Pose2 pose;
};

/// Keeps its memory between moments.
class LeftOver {
public:
    /// All that the cameras see, with shadows weighed by what several of them see of the floor.
    void begin(std::span<const SeenBy> cameras);
    /// The cameras with what is left.
    std::span<const SeenBy> moment() const { return moment_; }

    /// What a body covers says nothing about others: neither that they are there, nor that they are not. What `others` cover beside it is no shadow of it.
    void take_away(const StandingBody& taken, std::span<const StandingBody> others);
    /// The same until put_back().
    void try_away(const StandingBody& taken, std::span<const StandingBody> others);
    void put_back();

private:
    using Changes = std::vector<Evidence::Change>;
    void take_away(std::size_t camera, const StandingBody& taken, std::span<const StandingBody> others, Changes* before);
    bool list_pixels(const SeenBy& camera, const StandingBody& taken);
    void spare(std::size_t camera, std::span<const StandingBody> others);

    std::vector<Evidence> left_;  // of each camera
    std::vector<SeenBy> moment_;
    std::vector<Changes> on_trial_;  // of each camera, as they were before
    // Working memory.
    BodyMask mask_;
    std::vector<int> covered_;                                   // pixels of the body that is taken away
    std::vector<std::pair<std::size_t, std::uint16_t>> spared_;  // pixels of other bodies and what of them may be a shadow
};

}  // namespace roomfix
