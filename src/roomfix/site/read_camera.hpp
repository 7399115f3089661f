// The part of a site file that describes a camera.
#pragma once

#include <string>

#include "roomfix/site/site.hpp"
#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {

constexpr double tallest = 1000;  // m: nothing in a site file is higher

/// Adds the camera to the site; what is wrong with it goes to the reader. `site.folder` is where its files are.
void read_camera(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site);

}  // namespace roomfix
