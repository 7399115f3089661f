#include "roomfix/site/read_installed.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <variant>

#include "roomfix/geometry/pose.hpp"
#include "roomfix/site/read_tag.hpp"

namespace roomfix {
namespace {

void read_beacon(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site) {
    const std::string what = "beacons." + id;
    if (!reader.map(node, what, {"position", "address"})) return;
    SiteBeacon beacon{id};
    beacon.position = reader.point3(reader.required(node, "position", what), what + ".position").value_or(beacon.position);
    beacon.address = reader.text(node["address"], what + ".address").value_or("");
    for (const SiteBeacon& other : site.beacons) {
        const bool same = !beacon.address.empty() && (beacon.address == other.address || beacon.address == other.id);
        if (same || other.address == id) {
            reader.error(node, fmt::format("{}: beacon {} is called the same: ranges could not be told apart; give each its own address", what, other.id));
        }
    }
    site.beacons.push_back(beacon);
}

void read_tag_landmark(YamlReader& reader, const YAML::Node& node, const std::string& what, const Eigen::Vector3d& position, double yaw, SiteLandmark& landmark,
                       const Site& site) {
    if (const auto tag = read_tag(reader, node, "tag", what)) landmark.kind = *tag;
    const std::string facing = reader.text(node["facing"], what + ".facing").value_or("down");
    if (facing != "down" && facing != "up" && facing != "wall") {
        reader.error(node["facing"], fmt::format("{}.facing must be down (ceiling), wall or up (floor), not '{}'", what, facing));
    }
    landmark.map_from_landmark = tag_pose(position, yaw, facing == "wall" ? Facing::wall : facing == "up" ? Facing::up : Facing::down);
    for (const SiteLandmark& other : site.landmarks) {
        const auto* tag = std::get_if<Tag>(&other.kind);
        if (tag && std::holds_alternative<Tag>(landmark.kind) && std::get<Tag>(landmark.kind).is(tag->family, tag->number)) {
            reader.error(node["tag"], fmt::format("{}.tag: tag {} is landmark {} already: print another number", what, tag->number, other.id));
        }
    }
}

void read_landmark(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site) {
    const std::string what = "landmarks." + id;
    if (!reader.map(node, what, {"position", "yaw_deg", "legs", "tag", "family", "size", "facing", "beacon", "sigma", "tilt_sigma_deg"})) return;
    SiteLandmark landmark{id};
    const Eigen::Vector3d position = reader.point3(reader.required(node, "position", what), what + ".position").value_or(Eigen::Vector3d::Zero());
    const double yaw = radians(reader.number(node["yaw_deg"], what + ".yaw_deg", -360, 360).value_or(0));
    const bool is_tag = node["tag"].IsDefined();
    if (is_tag && node["legs"].IsDefined()) {
        reader.error(node, fmt::format("{} needs only one of legs: [a, b] (three LEDs) or tag: number and size: edge (a square tag)", what));
    } else if (is_tag) {
        read_tag_landmark(reader, node, what, position, yaw, landmark, site);
    } else {
        landmark.kind = PointMark{};
        if (const auto legs = reader.numbers(node["legs"], what + ".legs", 2, 0.001, 10)) landmark.kind = LedTriangle{(*legs)[0], (*legs)[1]};
        landmark.map_from_landmark = Eigen::Translation3d(position) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
        for (const char* other : {"family", "size", "facing", "tilt_sigma_deg"}) {
            if (node[other].IsDefined())
                reader.error(node[other], fmt::format("{}.{} belongs to a tag: give the tag's number as {}.tag; three LEDs have legs, a mere point neither",
                                                      what, other, what));
        }
    }
    landmark.sigma = reader.number(node["sigma"], what + ".sigma", 0, 10).value_or(landmark.sigma);
    if (const auto tilt = reader.number(node["tilt_sigma_deg"], what + ".tilt_sigma_deg", 0, 45)) landmark.tilt_sigma = radians(*tilt);
    landmark.beacon = reader.text(node["beacon"], what + ".beacon").value_or("");
    const bool known = std::any_of(site.beacons.begin(), site.beacons.end(), [&](const auto& b) { return b.id == landmark.beacon; });
    if (!landmark.beacon.empty() && !known) {
        reader.error(node["beacon"], fmt::format("{}.beacon: there is no beacon '{}' under beacons", what, landmark.beacon));
    }
    site.landmarks.push_back(landmark);
}

void read_corner(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site) {
    const std::string what = "corners." + id;
    if (!reader.map(node, what, {"position", "yaw_deg", "angle_deg", "sigma", "moulding"})) return;
    SiteCorner corner{id};
    const auto position = reader.point3(reader.required(node, "position", what), what + ".position");
    corner.position = position.value_or(corner.position);
    corner.yaw = radians(reader.number(node["yaw_deg"], what + ".yaw_deg", -360, 360).value_or(0));
    corner.wall_angle = radians(reader.number(node["angle_deg"], what + ".angle_deg", 20, 160).value_or(90));
    corner.sigma = reader.number(node["sigma"], what + ".sigma", 0, 10).value_or(corner.sigma);
    corner.moulding = reader.number(node["moulding"], what + ".moulding", 0, 0.999);
    if (corner.moulding && *corner.moulding > 0 && *corner.moulding < 0.001) {
        reader.error(node["moulding"],
                     fmt::format("{}.moulding: {} m is no moulding: state its height in metres, or 0 if there is none", what, *corner.moulding));
    }
    if (position && !(position->z() > 0)) {
        reader.error(node["position"],
                     fmt::format("{}.position: z is {}: a corner under the ceiling is that high above the floor, in metres", what, position->z()));
    }
    site.corners.push_back(corner);
}

}  // namespace

void read_installed(YamlReader& reader, const YAML::Node& root, Site& site) {
    for (const auto& [id, node] : reader.named(root["beacons"], "beacons")) read_beacon(reader, id, node, site);
    for (const auto& [id, node] : reader.named(root["landmarks"], "landmarks")) read_landmark(reader, id, node, site);
    for (const auto& [id, node] : reader.named(root["corners"], "corners")) read_corner(reader, id, node, site);
}

}  // namespace roomfix
