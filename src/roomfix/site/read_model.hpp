// The model file of a robot: a body that was learned, a URDF, or a mesh.
#pragma once

#include <string>

#include "roomfix/site/site.hpp"
#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {

/// Fills the robot's shape, parts and learned body from `model` and `scale` (the keys `model` and `model_scale`; the latter may be
/// undefined); what is wrong goes to the reader, at the line of `model`. `what`: the robot's name in messages; `site`: where
/// relative paths start.
void read_model(YamlReader& reader, const YAML::Node& model, const YAML::Node& scale, const std::string& what, const Site& site, SiteRobot& robot);

}  // namespace roomfix
