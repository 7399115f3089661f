#include "roomfix/site/read_tag.hpp"

#include <fmt/format.h>

#include <cmath>

namespace roomfix {

std::optional<Tag> read_tag(YamlReader& reader, const YAML::Node& node, const char* number_key, const std::string& what) {
    Tag tag;
    if (const auto name = reader.text(node["family"], what + ".family")) {
        const auto family = tag_family_named(*name);
        if (!family) reader.error(node["family"], fmt::format("{}.family is '{}': write one of {}", what, *name, fmt::join(tag_family_names(), ", ")));
        tag.family = family.value_or(tag.family);
    }
    const auto number = reader.integer(reader.required(node, number_key, what), what + "." + number_key, 0, tag_count(tag.family) - 1);
    const auto size = reader.number(reader.required(node, "size", what), what + ".size", 0.005, 10);
    if (!number || !size) return std::nullopt;
    tag.number = *number;
    tag.size = *size;
    return tag;
}

Eigen::Isometry3d tag_pose(const Eigen::Vector3d& position, double yaw, Facing facing) {
    const Eigen::Vector3d along(std::cos(yaw), std::sin(yaw), 0);
    const Eigen::Vector3d up = facing == Facing::wall ? Eigen::Vector3d(Eigen::Vector3d::UnitZ()) : along;
    const Eigen::Vector3d out = facing == Facing::wall ? along : Eigen::Vector3d(0, 0, facing == Facing::up ? 1 : -1);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() << up.cross(out), up, out;
    pose.translation() = position;
    return pose;
}

}  // namespace roomfix
