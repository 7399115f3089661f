#include "roomfix/site/body_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace roomfix {
namespace {

constexpr int cylinder_sides = 16;

}  // namespace

ConvexPart box_part(const Box& box, const Eigen::Isometry3d& robot_from_part) {
    ConvexPart part;
    const Eigen::Vector3d half = half_size(box);
    for (int i = 0; i < 8; ++i) {
        part.points.push_back(robot_from_part * Eigen::Vector3d(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z()));
    }
    return part;
}

ConvexPart cylinder_part(const Cylinder& cylinder, const Eigen::Isometry3d& robot_from_part) {
    constexpr int rim = cylinder_sides;
    ConvexPart part;
    const double r = cylinder.diameter / 2 / (1 - 0.25 * std::pow(std::numbers::pi / rim, 2));
    for (int i = 0; i < 2 * rim; ++i) {
        const double angle = 2 * std::numbers::pi * (i % rim) / rim;
        const double z = i < rim ? -cylinder.height / 2 : cylinder.height / 2;
        part.points.push_back(robot_from_part * Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), z));
    }
    return part;
}

double lowest_point(const std::vector<ConvexPart>& parts) {
    double lowest = std::numeric_limits<double>::infinity();
    for (const ConvexPart& part : parts) {
        for (const auto& p : part.points) lowest = std::min(lowest, p.z());
    }
    return lowest;
}

Box box_around(const std::vector<ConvexPart>& parts) {
    Box box;
    for (const ConvexPart& part : parts) {
        for (const auto& p : part.points) {
            box.length = std::max(box.length, 2 * std::abs(p.x()));
            box.width = std::max(box.width, 2 * std::abs(p.y()));
            box.height = std::max(box.height, p.z());
        }
    }
    return box;
}

bool same_parts(const std::vector<ConvexPart>& a, const std::vector<ConvexPart>& b, double tolerance) {
    const auto near = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) { return (p - q).cwiseAbs().maxCoeff() < tolerance; };
    const auto same = [&](const ConvexPart& p, const ConvexPart& q) {
        return std::equal(p.points.begin(), p.points.end(), q.points.begin(), q.points.end(), near);
    };
    const auto all_in = [&](const std::vector<ConvexPart>& parts, const std::vector<ConvexPart>& others) {
        return std::all_of(parts.begin(), parts.end(), [&](const ConvexPart& part) {
            return std::any_of(others.begin(), others.end(), [&](const ConvexPart& other) { return same(part, other); });
        });
    };
    return a.size() == b.size() && all_in(a, b) && all_in(b, a);
}

double symmetry_of(const std::vector<ConvexPart>& parts) {
    constexpr double tolerance = 0.002;  // m
    const auto same_after = [&](double angle) {
        const Eigen::AngleAxisd turn(angle, Eigen::Vector3d::UnitZ());
        const auto is_corner = [&](const Eigen::Vector3d& p) {
            return std::any_of(parts.begin(), parts.end(), [&](const ConvexPart& part) {
                return std::any_of(part.points.begin(), part.points.end(), [&](const Eigen::Vector3d& q) { return (p - q).norm() < tolerance; });
            });
        };
        return std::all_of(parts.begin(), parts.end(), [&](const ConvexPart& part) {
            return std::all_of(part.points.begin(), part.points.end(), [&](const Eigen::Vector3d& p) { return is_corner(turn * p); });
        });
    };
    constexpr double pi = std::numbers::pi;
    if (same_after(2 * pi / cylinder_sides)) return 0;
    if (same_after(pi / 2)) return pi / 2;
    return same_after(pi) ? pi : 2 * pi;
}

}  // namespace roomfix
