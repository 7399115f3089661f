// Square tags in a site file: on robots and on walls, floor and ceiling.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "roomfix/site/site.hpp"
#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {

/// Number, size and family; what is wrong goes to the reader. `number_key`: under which the number stands.
std::optional<Tag> read_tag(YamlReader& reader, const YAML::Node& node, const char* number_key, const std::string& what);

enum class Facing { down, up, wall };

/// The tag's frame in its holder's: on the ceiling and on the floor `yaw` is where its upper edge points, on a wall where its
/// face looks.
Eigen::Isometry3d tag_pose(const Eigen::Vector3d& position, double yaw, Facing facing);

}  // namespace roomfix
