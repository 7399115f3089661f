// The part of a site file that describes a robot.
#pragma once

#include <string>

#include "roomfix/site/site.hpp"
#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {

/// Adds the robot to the site; what is wrong with it goes to the reader.
void read_robot(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site);

}  // namespace roomfix
