// Fixes as JSON, one object per line, as in docs/formats.md.
#pragma once

#include <string>

#include "roomfix/observation/fix.hpp"

namespace roomfix {

/// As the records call it: ok, coasting, none.
const char* name_of(FixStatus status);

/// The fix record without a line end.
std::string fix_line(const Fix& fix);

}  // namespace roomfix
