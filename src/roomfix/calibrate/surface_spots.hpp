// Evenly spread spots on the surface of a body, and the colours that pictures show there.
#pragma once

#include <vector>

#include "roomfix/calibrate/occupancy.hpp"

namespace roomfix {

struct SpotSettings {
    int spots = 900;           // about so many
    double first_sigma = 0.2;  // of a log colour, before it was seen several times ...
    double first_sights = 2;   // ... which counts as much as so many sights
    double least_sigma = 0.08;
    double least_filled = 0.5;  // part of a spot's sights that differ from the background: others are no body
    LookSettings look;
};

/// The tops and the sides of upright parts; what is inside another part is left out.
std::vector<LookSpot> spots_on(const std::vector<ConvexPart>& parts, int about);

/// The look of spots, each from all sights that show it. `round`: all spots of one height look alike. Spots that were not seen, or that
/// show the background, are left out.
BodyLook look_from(const std::vector<BodyMoment>& moments, const std::vector<BodySight>& sights, const std::vector<LookSpot>& spots, bool round,
                   const SpotSettings& settings);

}  // namespace roomfix
