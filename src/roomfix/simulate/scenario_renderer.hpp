// What the cameras of a scenario see, time after time.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "roomfix/imaging/luma.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {

/// Fixed cameras come first, then those that look up, then those that look for corners.
std::size_t camera_count(const Scenario& scenario);
const std::string& camera_id(const Scenario& scenario, std::size_t camera);

/// One camera of a scenario.
class ScenarioRenderer {
public:
    /// `scenario` is kept by reference. `seed` is of noise and light. `turned` (rad, about the map's z) knocks a fixed camera out of its direction.
    ScenarioRenderer(const Scenario& scenario, std::size_t camera, std::uint64_t seed, double turned = 0);

    /// The picture at a time (s). The same `index` gives the same noise.
    void render(double time, std::uint64_t index, LumaImage& frame);
    /// What a fixed camera saw before the robots came: 0.1 s from picture to picture.
    void render_empty(std::uint64_t index, LumaImage& frame);

private:
    std::vector<Solid> solids_at(double time) const;

    const Scenario& scenario_;
    std::size_t number_;  // among the cameras of its kind
    std::uint64_t seed_;
    std::variant<CameraRenderer, CeilingRenderer, RoomRenderer> renderer_;
};

}  // namespace roomfix
