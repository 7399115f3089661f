#include "roomfix/site/read_zone.hpp"

#include <fmt/format.h>

#include <cmath>

namespace roomfix {
namespace {

constexpr double least_area = 1e-4;  // m^2: smaller is a slip of the hand

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Do the lines a-b and c-d cross, each other's ends left out?
bool lines_cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
    const auto apart = [](const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
        return cross(to - from, p - from) * cross(to - from, q - from) < 0;
    };
    return apart(a, b, c, d) && apart(c, d, a, b);
}

bool crosses_itself(const Polyline& border) {
    const std::size_t n = border.size();
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 2; j < n; ++j) {
            if (lines_cross(border[i], border[i + 1], border[j], border[(j + 1) % n])) return true;
        }
    }
    return false;
}

double area_of(const Polyline& border) {
    double twice = 0;
    for (std::size_t i = 0; i < border.size(); ++i) twice += cross(border[i] - border[0], border[(i + 1) % border.size()] - border[0]);
    return std::abs(twice) / 2;
}

}  // namespace

std::string border_problem(const Polyline& border) {
    if (border.size() < 3) return "needs three or more corners [x, y]";
    if (border.size() > most_zone_corners) return fmt::format("has {} corners: {} are enough for any floor", border.size(), most_zone_corners);
    if (crosses_itself(border)) return "crosses its own border: give the corners in the order of a walk around it";
    if (area_of(border) < least_area) return "has no area: its corners lie on a line";
    return "";
}

SiteZone read_zone(YamlReader& reader, const std::string& id, const YAML::Node& node) {
    SiteZone zone{id, {}};
    const std::string what = "zones." + id;
    if (!node.IsSequence() || node.size() < 3) {
        reader.error(node, what + " needs three or more corners [x, y]");
        return zone;
    }
    for (const auto& corner : node) {
        if (const auto p = reader.point2(corner, what)) zone.border.push_back(*p);
    }
    if (zone.border.size() != node.size()) return zone;
    if (const std::string problem = border_problem(zone.border); !problem.empty()) reader.error(node, what + " " + problem);
    return zone;
}

}  // namespace roomfix
