#include "roomfix/site/read_body.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "roomfix/geometry/pose.hpp"
#include "roomfix/site/body_parts.hpp"
#include "roomfix/site/read_model.hpp"

namespace roomfix {
namespace {

constexpr double smallest = 0.01;  // m
constexpr double largest = 50;     // m

void read_shape(YamlReader& reader, const YAML::Node& node, const std::string& what, SiteRobot& robot) {
    const auto kind = reader.text(reader.required(node, "shape", what), what + ".shape");
    const YAML::Node size = reader.required(node, "size", what);
    if (kind == "box") {
        if (const auto s = reader.numbers(size, what + ".size (length, width, height)", 3, smallest, largest)) {
            robot.shape = Box{(*s)[0], (*s)[1], (*s)[2]};
        }
    } else if (kind == "cylinder") {
        if (const auto s = reader.numbers(size, what + ".size (diameter, height)", 2, smallest, largest)) {
            robot.shape = Cylinder{(*s)[0], (*s)[1]};
        }
    } else if (kind) {
        reader.error(node["shape"], fmt::format("{}.shape must be box or cylinder, not '{}'", what, *kind));
    }
}

constexpr double thinnest = 0.001;  // m: a part may be a plate or a pole

std::optional<Eigen::Vector3d> read_place(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    const auto v = reader.numbers(node, what, 3, -largest, largest);
    if (!v) return std::nullopt;
    return Eigen::Vector3d((*v)[0], (*v)[1], (*v)[2]);
}

/// A box or a cylinder at a place of the robot.
std::optional<ConvexPart> read_solid_part(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    const auto at = read_place(reader, reader.required(node, "at", what), what + ".at (the part's middle)");
    const double yaw = radians(reader.number(node["yaw_deg"], what + ".yaw_deg", -360, 360).value_or(0));
    const Eigen::Isometry3d pose = Eigen::Translation3d(at.value_or(Eigen::Vector3d::Zero())) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
    if (node["box"].IsDefined()) {
        const auto s = reader.numbers(node["box"], what + ".box (length, width, height)", 3, thinnest, largest);
        if (at && s) return box_part({(*s)[0], (*s)[1], (*s)[2]}, pose);
    } else {
        const auto s = reader.numbers(node["cylinder"], what + ".cylinder (diameter, height)", 2, thinnest, largest);
        if (at && s) return cylinder_part({(*s)[0], (*s)[1]}, pose);
    }
    return std::nullopt;
}

/// Any convex solid, by its corners.
std::optional<ConvexPart> read_points_part(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    for (const char* other : {"at", "yaw_deg"}) {
        if (node[other].IsDefined())
            reader.error(node[other], fmt::format("{}.{} belongs to a box or a cylinder: points stand in the robot frame", what, other));
    }
    const YAML::Node points = node["points"];
    if (!reader.list(points, what + ".points")) return std::nullopt;
    if (points.size() < 4 || points.size() > most_points_of_part) {
        reader.error(points,
                     fmt::format("{}.points has {} points: a convex part is made of 4 to {} corners [x, y, z]", what, points.size(), most_points_of_part));
        return std::nullopt;
    }
    ConvexPart part;
    for (const auto& item : points) {
        if (const auto p = read_place(reader, item, fmt::format("{}.points[{}]", what, part.points.size()))) part.points.push_back(*p);
    }
    if (part.points.size() != points.size()) return std::nullopt;
    return part;
}

std::optional<ConvexPart> read_part(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    if (!reader.map(node, what, {"box", "cylinder", "points", "at", "yaw_deg"})) return std::nullopt;
    const int kinds = node["box"].IsDefined() + node["cylinder"].IsDefined() + node["points"].IsDefined();
    if (kinds != 1) {
        reader.error(node, fmt::format("{} needs {} box: [length, width, height], cylinder: [diameter, height] and points: [[x, y, z], ...]", what,
                                       kinds == 0 ? "one of" : "only one of"));
        return std::nullopt;
    }
    return node["points"].IsDefined() ? read_points_part(reader, node, what) : read_solid_part(reader, node, what);
}

/// A body stands on the floor, z = 0 of the robot frame.
void check_floor(YamlReader& reader, const YAML::Node& node, const std::string& what, const std::vector<ConvexPart>& parts) {
    constexpr double above = 0.05;  // m
    constexpr double below = 0.01;  // m
    const double lowest = lowest_point(parts);
    if (lowest > above) {
        reader.error(node, fmt::format("{}: the lowest point is {:.2f} m above the floor: add the part that the robot stands on, or lower the parts ('at' is a "
                                       "part's middle, z = 0 the floor)",
                                       what, lowest));
    } else if (lowest < -below) {
        reader.error(
            node, fmt::format("{}: the lowest point is {:.2f} m below the floor: raise that part by half its height ('at' is a part's middle, z = 0 the floor)",
                              what, -lowest));
    }
}

void read_parts(YamlReader& reader, const YAML::Node& node, const std::string& what, SiteRobot& robot) {
    if (!reader.list(node, what)) return;
    if (node.size() == 0 || node.size() > most_parts) {
        reader.error(
            node, fmt::format("{} has {} parts: write 1 to {}, each a map such as {{box: [0.5, 0.4, 0.3], at: [0, 0, 0.15]}}", what, node.size(), most_parts));
        return;
    }
    std::vector<ConvexPart> parts;
    std::size_t index = 0;
    for (const auto& item : node) {
        if (auto part = read_part(reader, item, fmt::format("{}[{}]", what, index++))) parts.push_back(std::move(*part));
    }
    if (parts.size() != node.size()) return;
    check_floor(reader, node, what, parts);
    const Box around = box_around(parts);
    if (std::min({around.length, around.width, around.height}) < smallest) {
        reader.error(node, fmt::format("{} are flat: a robot is at least {} m long, wide and high", what, smallest));
        return;
    }
    robot.shape = around;
    robot.parts = std::move(parts);
}

}  // namespace

void read_body(YamlReader& reader, const YAML::Node& node, const std::string& what, const Site& site, SiteRobot& robot) {
    const YAML::Node parts = node["parts"];
    const YAML::Node model = node["model"];
    const YAML::Node scale = node["model_scale"];
    const bool shaped = node["shape"].IsDefined() || node["size"].IsDefined();
    const int kinds = shaped + parts.IsDefined() + model.IsDefined();
    if (kinds > 1)
        reader.error(model.IsDefined() ? model : parts, fmt::format("{} has more than one of shape and size, parts, and model: keep one of them", what));
    if (kinds == 0) reader.error(node, fmt::format("{} needs a body: shape and size, or parts, or model", what));
    if (scale.IsDefined() && !model.IsDefined()) reader.error(scale, fmt::format("{}.model_scale belongs to 'model': there is none", what));
    if (kinds != 1) return;
    if (shaped) read_shape(reader, node, what, robot);
    if (parts.IsDefined()) read_parts(reader, parts, what + ".parts", robot);
    if (model.IsDefined()) read_model(reader, model, scale, what, site, robot);
}

}  // namespace roomfix
