// The zones of a site file.
#pragma once

#include <string>

#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {

constexpr std::size_t most_zone_corners = 200;

/// Why a border encloses no area that one could be in or not, as the end of a sentence that begins with its name; empty: it does.
std::string border_problem(const Polyline& border);

SiteZone read_zone(YamlReader& reader, const std::string& id, const YAML::Node& node);

}  // namespace roomfix
