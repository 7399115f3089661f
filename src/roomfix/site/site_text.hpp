// A site as the text of a site file.
#pragma once

#include <string>

#include "roomfix/site/site.hpp"

namespace roomfix {

/// YAML of format 1 that parse_site() reads back to the same site. Numbers are written in full.
std::string site_text(const Site& site);

}  // namespace roomfix
