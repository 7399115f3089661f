#include "roomfix/site/site_text.hpp"

#include <fmt/format.h>

#include "roomfix/base/number.hpp"

namespace roomfix {
namespace {

template <class Range>
std::string list_text(const Range& values) {
    std::string text = "[";
    for (const double v : values) text += (text.size() > 1 ? ", " : "") + number_text(v);
    return text + "]";
}

std::string pose_text(const Eigen::Isometry3d& pose) {
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d p = pose.translation();
    return fmt::format("position: {}, quaternion: {}", list_text(std::array{p.x(), p.y(), p.z()}), list_text(std::array{q.x(), q.y(), q.z(), q.w()}));
}

struct PlacementText {
    std::string operator()(const KnownPose& known) const {
        std::string text = "    pose: {" + pose_text(known.map_from_camera.pose);
        if (known.has_covariance) {
            const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> p = known.map_from_camera.covariance;
            text += ", covariance: " + list_text(std::vector<double>(p.data(), p.data() + 36));
        }
        return text + "}\n";
    }
    std::string operator()(const KnownFloorPoints& floor) const {
        std::string text = fmt::format("    floor_points_sigma: {}\n    floor_points:\n", number_text(floor.sigma));
        for (const FloorPoint& p : floor.points) {
            text += fmt::format("      - {{pixel: {}, map: {}}}\n", list_text(p.pixel), list_text(p.map));
        }
        return text;
    }
    std::string operator()(const Mount& mount) const { return fmt::format("    mount: {{robot: {}, {}}}\n", mount.robot, pose_text(mount.robot_from_camera)); }
    std::string operator()(const KnownHeight& known) const {
        return fmt::format("    height: {}\n    height_sigma: {}\n{}", number_text(known.height), number_text(known.sigma),
                           known.robot.empty() ? "" : "    robot: " + known.robot + "\n");
    }
};

std::string camera_text(const SiteCamera& camera) {
    const CameraModel& m = camera.model;
    std::string text = fmt::format("  {}:\n    source: {}\n    size: [{}, {}]\n", camera.id, camera.source, m.width, m.height);
    text += fmt::format("    intrinsics: {{fx: {}, fy: {}, cx: {}, cy: {}}}\n    distortion: {}\n", number_text(m.fx), number_text(m.fy), number_text(m.cx),
                        number_text(m.cy), list_text(m.distortion));
    text += std::visit(PlacementText{}, camera.placement);
    if (!camera.background.empty()) text += "    background: " + camera.background + "\n";
    return text;
}

std::string robot_text(const SiteRobot& robot) {
    std::string shape;
    if (const auto* box = std::get_if<Box>(&robot.shape)) {
        shape = "shape: box, size: " + list_text(std::array{box->length, box->width, box->height});
    } else {
        const auto& cylinder = std::get<Cylinder>(robot.shape);
        shape = "shape: cylinder, size: " + list_text(std::array{cylinder.diameter, cylinder.height});
    }
    return fmt::format("  {}: {{{}, size_sigma: {}{}}}\n", robot.id, shape, number_text(robot.size_sigma), robot.many ? ", count: many" : "");
}

}  // namespace

std::string site_text(const Site& site) {
    std::string text = fmt::format("roomfix: 1\nsite:\n  name: {}\n", site.name);
    if (site.ceiling > 0) text += "  ceiling: " + number_text(site.ceiling) + "\n";
    if (!site.walls.empty()) {
        text += "  walls:\n";
        for (const Polyline& line : site.walls) {
            text += "    - [";
            for (std::size_t i = 0; i < line.size(); ++i) text += (i ? ", " : "") + list_text(line[i]);
            text += "]\n";
        }
    }
    if (!site.cameras.empty()) text += "cameras:\n";
    for (const auto& camera : site.cameras) text += camera_text(camera);
    if (!site.robots.empty()) text += "robots:\n";
    for (const auto& robot : site.robots) text += robot_text(robot);
    if (!site.beacons.empty()) text += "beacons:\n";
    for (const auto& b : site.beacons) text += fmt::format("  {}: {{position: {}}}\n", b.id, list_text(b.position));
    if (!site.landmarks.empty()) text += "landmarks:\n";
    for (const auto& l : site.landmarks) {
        text += fmt::format("  {}: {{position: {}, yaw_deg: {}, legs: {}{}}}\n", l.id, list_text(l.position), number_text(degrees(l.yaw)), list_text(l.legs),
                            l.beacon.empty() ? "" : ", beacon: " + l.beacon);
    }
    if (!site.corners.empty()) text += "corners:\n";
    for (const auto& c : site.corners) text += fmt::format("  {}: {{position: {}, yaw_deg: {}}}\n", c.id, list_text(c.position), number_text(degrees(c.yaw)));
    if (site.outputs.web || !site.outputs.jsonl.empty()) {
        text += "outputs:\n";
        if (site.outputs.web) text += fmt::format("  web: {{host: {}, port: {}}}\n", site.outputs.web->host, site.outputs.web->port);
        if (!site.outputs.jsonl.empty()) text += "  jsonl: " + site.outputs.jsonl + "\n";
    }
    return text;
}

}  // namespace roomfix
