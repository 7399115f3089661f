#include "roomfix/site/read_robot.hpp"

#include <fmt/format.h>

#include "roomfix/geometry/pose.hpp"
#include "roomfix/site/read_body.hpp"
#include "roomfix/site/read_tag.hpp"

namespace roomfix {
namespace {

Receiver read_receiver(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    Receiver receiver;
    if (!reader.map(node, what, {"position", "source", "sigma", "bias_sigma", "scale_sigma"})) return receiver;
    receiver.position = reader.point3(reader.required(node, "position", what), what + ".position").value_or(receiver.position);
    receiver.source = reader.text(node["source"], what + ".source").value_or("");
    receiver.sigma = reader.number(node["sigma"], what + ".sigma", 1e-5, 100).value_or(receiver.sigma);
    receiver.bias_sigma = reader.number(node["bias_sigma"], what + ".bias_sigma", 0, 100).value_or(receiver.bias_sigma);
    receiver.scale_sigma = reader.number(node["scale_sigma"], what + ".scale_sigma", 0, 1).value_or(receiver.scale_sigma);
    return receiver;
}

WheelOdometry read_odometry(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    WheelOdometry odometry;
    if (!reader.map(node, what, {"source", "scale_sigma", "drift_sigma"})) return odometry;
    odometry.source = reader.text(node["source"], what + ".source").value_or("");
    odometry.scale_sigma = reader.number(node["scale_sigma"], what + ".scale_sigma", 0, 1).value_or(odometry.scale_sigma);
    odometry.drift_sigma = reader.number(node["drift_sigma"], what + ".drift_sigma", 0, 10).value_or(odometry.drift_sigma);
    return odometry;
}

/// A tag on the robot's top: its upper edge points forward at yaw 0.
void read_robot_tag(YamlReader& reader, const YAML::Node& node, const std::string& what, SiteRobot& robot) {
    if (!reader.map(node, what, {"id", "size", "position", "yaw_deg"})) return;
    robot.tag = read_tag(reader, node, "id", what);
    const auto position = reader.point3(reader.required(node, "position", what), what + ".position");
    const double yaw = radians(reader.number(node["yaw_deg"], what + ".yaw_deg", -360, 360).value_or(0));
    robot.robot_from_tag = tag_pose(position.value_or(Eigen::Vector3d::Zero()), yaw, Facing::up);
}

}  // namespace

void read_robot(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site) {
    const std::string what = "robots." + id;
    if (!reader.map(node, what, {"shape", "size", "size_sigma", "parts", "model", "model_scale", "count", "drive", "odometry", "receiver", "tag"})) return;
    SiteRobot robot;
    robot.id = id;
    read_body(reader, node, what, site, robot);
    robot.size_sigma = reader.number(node["size_sigma"], what + ".size_sigma", 1e-5, 10).value_or(robot.size_sigma);
    if (const auto count = reader.text(node["count"], what + ".count")) {
        robot.many = *count == "many";
        if (*count != "many" && *count != "1") reader.error(node["count"], what + ".count must be 'many' or 1");
    }
    if (const auto drive = reader.text(node["drive"], what + ".drive")) {
        if (*drive == "differential") robot.drive = Drive::differential;
        if (*drive == "holonomic") robot.drive = Drive::holonomic;
        if (*drive != "differential" && *drive != "holonomic" && *drive != "unknown") {
            reader.error(node["drive"], fmt::format("{}.drive must be differential, holonomic or unknown, not '{}'", what, *drive));
        }
    }
    if (node["odometry"].IsDefined()) robot.odometry = read_odometry(reader, node["odometry"], what + ".odometry");
    if (node["receiver"].IsDefined()) robot.receiver = read_receiver(reader, node["receiver"], what + ".receiver");
    if (node["tag"].IsDefined()) read_robot_tag(reader, node["tag"], what + ".tag", robot);
    for (const char* single : {"odometry", "receiver", "tag"}) {
        if (robot.many && node[single].IsDefined()) {
            reader.error(node[single], fmt::format("{}.{}: there are many of this robot: give each robot with a {} an entry of its own", what, single, single));
        }
    }
    site.robots.push_back(robot);
}

}  // namespace roomfix
