// Shadows lie on the floor: several cameras together tell them from what stands there.
#pragma once

#include <span>

#include "roomfix/overhead/body_search.hpp"

namespace roomfix {

/// What may as well be a shadow in one camera is none where another camera sees that part of the floor as it always is: those pixels show something that
/// stands there. `evidence`: of each camera, a copy of what it sees; its sums have to be filled anew.
void rule_out_shadows(std::span<const SeenBy> cameras, std::span<Evidence> evidence);

}  // namespace roomfix
