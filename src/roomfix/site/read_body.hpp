// The part of a site file that says what a robot's body looks like: a simple shape, parts, or a model file.
#pragma once

#include <filesystem>
#include <string>

#include "roomfix/site/site.hpp"
#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {

/// Fills the robot's shape, parts, model and learned body from its keys `shape`, `size`, `parts`, `model` and
/// `model_scale`; what is wrong with them goes to the reader. `what`: the robot's name in messages; `site`: where relative paths start.
void read_body(YamlReader& reader, const YAML::Node& node, const std::string& what, const Site& site, SiteRobot& robot);

}  // namespace roomfix
