// A site as the text of a site file.
#pragma once

#include <string>

#include "roomfix/site/site.hpp"

namespace roomfix {

/// YAML of format 1 that parse_site() reads back to the same site. Numbers are written in full.
std::string site_text(const Site& site);

/// The value of a camera's `mount` key, on one line: {robot: ..., position: ..., quaternion: ..., covariance: ...}.
std::string mount_text(const Mount& mount);

}  // namespace roomfix
