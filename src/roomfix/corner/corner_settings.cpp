#include "roomfix/corner/corner_settings.hpp"

#include <algorithm>

namespace roomfix {

CornerSettings in_pixels_of(const CameraModel& model, CornerSettings settings) {
    const double unit = length_unit(model);
    for (double* length : {&settings.long_edge, &settings.second_edge, &settings.short_edge, &settings.plain_edges, &settings.largest_gap}) *length *= unit;
    settings.short_edge = std::max(settings.short_edge, settings.fit.stretch);
    return settings;
}

}  // namespace roomfix
