// The outputs as a site file's text.
#pragma once

#include <string>

#include "roomfix/site/outputs.hpp"

namespace roomfix {

/// `outputs:` and what is under it; empty where there is none.
std::string outputs_text(const Outputs& outputs);

}  // namespace roomfix
