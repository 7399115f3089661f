// Times as ISO 8601 text, as other programs' records have them.
#pragma once

#include <string>

#include "roomfix/base/time.hpp"

namespace roomfix {

/// UTC with milliseconds: 1970-01-01T00:00:12.345Z.
std::string iso_time(Nanoseconds time);

}  // namespace roomfix
