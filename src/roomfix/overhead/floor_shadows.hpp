// What several cameras know together of shadows.
#pragma once

#include <span>

#include "roomfix/overhead/place_score.hpp"

namespace roomfix {

/// What counts as something else of pixels that may as well be a shadow.
struct FloorShadowSettings {
    float on_wall = 1;            // behind which a wall stands: shadows lie on floors
    float hidden_floor = 0.5f;    // whose place on the floor no other camera sees
    float agreed = 0.125f;        // whose place on the floor another camera sees in the same light
    float little = 0.25f;         // in cells that hardly have any
    float same_light = 0.1f;      // log of the light
    float plainly_floor = 0.95f;  // part of the pixels around a place that show the background: then another camera sees no shadow there
};

/// What one camera sees as a shadow lies on the floor: where another one sees the floor there and it looks as always, the first one sees something that
/// stands before it; where it sees it in the same light, it is a shadow. `evidence`: what is changed, for each camera; the sums have to be filled anew.
void weigh_shadows(std::span<const SeenBy> cameras, std::span<Evidence> evidence, const FloorShadowSettings& settings = {});

}  // namespace roomfix
