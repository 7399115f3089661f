// What robots' wheels reported, from files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/observation/odometry_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct OdometryBatch {
    std::vector<OdometryObservation> poses;  // in the order of the lines
    std::vector<std::string> problems;       // one sentence per line that was not used
};

/// CSV with a header that names `time`, `x`, `y`, `yaw` (s, m, m, rad) and perhaps `robot`, in any order; more columns are ignored; or JSON lines with the
/// same names. Lines
/// without a robot are `robot`'s (index in the site). Bad lines cost themselves only; an error if the header does not fit.
Result<OdometryBatch> parse_odometry(std::string_view text, const Site& site, int robot);

/// The same from a file, whose name is in the problems and in the error.
Result<OdometryBatch> load_odometry(const std::string& file, const Site& site, int robot);

}  // namespace roomfix
