#include "roomfix/site/read_tag.hpp"

#include <cmath>

namespace roomfix {

std::optional<Tag> read_tag(YamlReader& reader, const YAML::Node& node, const char* number_key, const std::string& what) {
    constexpr int last = 586;  // of tag36h11
    const auto number = reader.integer(reader.required(node, number_key, what), what + "." + number_key, 0, last);
    const auto size = reader.number(reader.required(node, "size", what), what + ".size", 0.005, 10);
    if (!number || !size) return std::nullopt;
    return Tag{*number, *size};
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
