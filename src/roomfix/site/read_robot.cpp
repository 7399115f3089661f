#include "roomfix/site/read_robot.hpp"

#include <fmt/format.h>

#include "roomfix/geometry/pose.hpp"
#include "roomfix/site/read_body.hpp"
#include "roomfix/site/read_tag.hpp"

namespace roomfix {
namespace {

constexpr std::size_t most_receivers = 8;

Receiver read_receiver(YamlReader& reader, const YAML::Node& node, const std::string& what, const SiteRobot& robot) {
    Receiver receiver = somewhere_on(robot);
    if (!reader.map(node, what, {"position", "position_sigma", "source", "sigma", "bias_sigma", "scale_sigma"})) return receiver;
    if (const auto position = node["position"].IsDefined() ? reader.point3(node["position"], what + ".position") : std::nullopt) {
        receiver.position = *position;
        receiver.position_sigma.setZero();
    }
    if (const auto sigma = reader.number(node["position_sigma"], what + ".position_sigma", 0, 10)) receiver.position_sigma.setConstant(*sigma);
    receiver.source = reader.text(node["source"], what + ".source").value_or("");
    receiver.sigma = reader.number(node["sigma"], what + ".sigma", 1e-5, 100).value_or(receiver.sigma);
    receiver.bias_sigma = reader.number(node["bias_sigma"], what + ".bias_sigma", 0, 100).value_or(receiver.bias_sigma);
    receiver.scale_sigma = reader.number(node["scale_sigma"], what + ".scale_sigma", 0, 1).value_or(receiver.scale_sigma);
    return receiver;
}

/// One receiver, or several by their names.
void read_receivers(YamlReader& reader, const YAML::Node& node, const std::string& what, SiteRobot& robot) {
    if (node["receiver"].IsDefined()) robot.receivers.push_back(read_receiver(reader, node["receiver"], what + ".receiver", robot));
    if (!node["receivers"].IsDefined()) return;
    if (!robot.receivers.empty())
        return reader.error(node["receivers"], fmt::format("{0}: 'receiver' is the short form for one: write {0}.receivers alone", what));
    for (const auto& [id, one] : reader.named(node["receivers"], what + ".receivers")) {
        robot.receivers.push_back(read_receiver(reader, one, what + ".receivers." + id, robot));
        robot.receivers.back().id = id;
    }
    if (robot.receivers.size() > most_receivers) {
        reader.error(node["receivers"], fmt::format("{}.receivers: {} are too many: at most {}", what, robot.receivers.size(), most_receivers));
    }
}

Detector read_detector(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    Detector detector;
    if (!reader.map(node, what, {"position", "position_sigma", "source", "range_sigma", "bearing_sigma"})) return detector;
    if (const auto position = node["position"].IsDefined() ? reader.point3(node["position"], what + ".position") : std::nullopt) {
        detector.position = *position;
    }
    if (const auto sigma = reader.number(node["position_sigma"], what + ".position_sigma", 0, 10)) detector.position_sigma.setConstant(*sigma);
    detector.source = reader.text(node["source"], what + ".source").value_or("");
    detector.range_sigma = reader.number(node["range_sigma"], what + ".range_sigma", 1e-5, 100).value_or(detector.range_sigma);
    detector.bearing_sigma = reader.number(node["bearing_sigma"], what + ".bearing_sigma", 1e-6, 3).value_or(detector.bearing_sigma);
    return detector;
}

WheelOdometry read_odometry(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    WheelOdometry odometry;
    if (!reader.map(node, what, {"source", "scale_sigma", "turn_scale_sigma", "drift_sigma"})) return odometry;
    odometry.source = reader.text(node["source"], what + ".source").value_or("");
    odometry.scale_sigma = reader.number(node["scale_sigma"], what + ".scale_sigma", 0, 1).value_or(odometry.scale_sigma);
    odometry.turn_scale_sigma = reader.number(node["turn_scale_sigma"], what + ".turn_scale_sigma", 0, 1).value_or(odometry.turn_scale_sigma);
    odometry.drift_sigma = reader.number(node["drift_sigma"], what + ".drift_sigma", 0, 10).value_or(odometry.drift_sigma);
    return odometry;
}

/// A tag on the robot's top: its upper edge points forward at yaw 0.
void read_robot_tag(YamlReader& reader, const YAML::Node& node, const std::string& what, SiteRobot& robot) {
    if (!reader.map(node, what, {"id", "family", "size", "position", "yaw_deg"})) return;
    robot.tag = read_tag(reader, node, "id", what);
    const auto position = reader.point3(reader.required(node, "position", what), what + ".position");
    const double yaw = radians(reader.number(node["yaw_deg"], what + ".yaw_deg", -360, 360).value_or(0));
    robot.robot_from_tag = tag_pose(position.value_or(Eigen::Vector3d::Zero()), yaw, Facing::up);
}

}  // namespace

void read_robot(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site) {
    const std::string what = "robots." + id;
    if (!reader.map(node, what,
                    {"shape", "size", "size_sigma", "parts", "model", "model_scale", "count", "drive", "odometry", "receiver", "receivers", "detector", "tag"}))
        return;
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
    read_receivers(reader, node, what, robot);
    if (node["detector"].IsDefined()) robot.detector = read_detector(reader, node["detector"], what + ".detector");
    if (node["tag"].IsDefined()) read_robot_tag(reader, node["tag"], what + ".tag", robot);
    for (const char* single : {"odometry", "receiver", "receivers", "detector", "tag"}) {
        if (robot.many && node[single].IsDefined()) {
            reader.error(node[single], fmt::format("{}.{}: there are many of this robot: give each robot with a {} an entry of its own", what, single, single));
        }
    }
    site.robots.push_back(robot);
}

}  // namespace roomfix
