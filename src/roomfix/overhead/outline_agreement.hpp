// Outlines of one robot in two cameras at the same moment: do they put it at one place?
#pragma once

#include "roomfix/observation/silhouette_observation.hpp"

namespace roomfix {

/// Nats by which the places of two outlines of one robot speak for the exact solid that is described, and not for a robot that is only about so large and
/// whose outlines are centimetres off. Negative: they are farther apart than they state.
double nats_of_agreement(const SilhouetteObservation& a, const SilhouetteObservation& b);

}  // namespace roomfix
