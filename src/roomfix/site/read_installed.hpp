// The part of a site file that describes what was put up for the robots, or was there already: beacons, landmarks, corners.
#pragma once

#include "roomfix/site/site.hpp"
#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {

/// Adds all of them to the site; what is wrong with them goes to the reader. `root`: the whole file.
void read_installed(YamlReader& reader, const YAML::Node& root, Site& site);

}  // namespace roomfix
