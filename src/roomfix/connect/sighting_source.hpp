// Landmarks that robots' own detectors saw, from files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/observation/sighting_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct SightingBatch {
    std::vector<SightingObservation> sightings;  // in the order of the lines
    std::vector<std::string> problems;           // one sentence per line that was not used
};

/// CSV with a header that names `time`, `range` or `bearing` or both, and perhaps `robot`, `landmark`, `range_sigma`, `bearing_sigma`, in any order (s, m, rad;
/// level with the floor, to the left of straight ahead positive); or JSON lines with the same names. A landmark that is left empty is not known by name; a
/// range or a bearing that is left empty was not seen. Lines without a robot are `robot`'s (index in the site). Bad lines cost themselves only; an error if
/// the header does not fit.
Result<SightingBatch> parse_sightings(std::string_view text, const Site& site, int robot);

/// The same from a file, whose name is in the problems and in the error.
Result<SightingBatch> load_sightings(const std::string& file, const Site& site, int robot);

}  // namespace roomfix
