// The outputs of a site file.
#pragma once

#include "roomfix/site/outputs.hpp"
#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {

Outputs read_outputs(YamlReader& reader, const YAML::Node& node);

}  // namespace roomfix
