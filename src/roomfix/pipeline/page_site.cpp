#include "roomfix/pipeline/page_site.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "roomfix/connect/json_text.hpp"
#include "roomfix/pipeline/camera_pipeline.hpp"
#include "roomfix/pipeline/error_map.hpp"
#include "roomfix/pipeline/page_numbers.hpp"

namespace roomfix {
namespace {

using nlohmann::json;

constexpr double farthest_view = 15;  // m: a field of view is drawn no farther than this

json point(const Eigen::Vector2d& p) { return {rounded(p.x(), 1e-4), rounded(p.y(), 1e-4)}; }

template <class Points>
json points_json(const Points& points) {
    json list = json::array();
    for (const auto& p : points) list.push_back(point(p.template head<2>()));
    return list;
}

/// The point between `from` and `to` where the first wall is met, or `to`.
Eigen::Vector2d up_to_wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const std::vector<Polyline>& walls) {
    const Eigen::Vector2d ray = to - from;
    double nearest = 1;
    for (const Polyline& line : walls) {
        for (std::size_t i = 1; i < line.size(); ++i) {
            const Eigen::Vector2d wall = line[i] - line[i - 1];
            const Eigen::Vector2d gap = line[i - 1] - from;
            const double cross = ray.x() * wall.y() - ray.y() * wall.x();
            if (std::abs(cross) < 1e-12) continue;
            const double along_ray = (gap.x() * wall.y() - gap.y() * wall.x()) / cross;
            const double along_wall = (gap.x() * ray.y() - gap.y() * ray.x()) / cross;
            if (along_ray > 0 && along_wall >= 0 && along_wall <= 1) nearest = std::min(nearest, along_ray);
        }
    }
    return from + nearest * ray;
}

/// The floor that a camera sees, as a polygon: the picture's border projected, cut off at walls and at a distance.
json field_of_view(const View& view, const std::vector<Polyline>& walls) {
    json polygon = json::array();
    const double w = view.model.width - 1.0;
    const double h = view.model.height - 1.0;
    constexpr int steps = 80;
    const auto add = [&](double u, double v) {
        const Eigen::Vector2d foot = view.position().head<2>();
        const auto floor = pixel_to_plane(view, {u, v}, 0);
        Eigen::Vector2d p;
        if (floor && (floor->point - foot).norm() < farthest_view) {
            p = floor->point;
        } else {
            const auto ray = unproject(view.model, {u, v});
            if (!ray) return;
            const Eigen::Vector3d direction = view.map_from_camera.pose.linear() * ray->homogeneous();
            if (direction.head<2>().norm() < 1e-9) return;
            p = foot + farthest_view * direction.head<2>().normalized();
        }
        polygon.push_back(point(up_to_wall(foot, p, walls)));
    };
    for (int i = 0; i < steps; ++i) add(w * i / steps, 0);
    for (int i = 0; i < steps; ++i) add(w, h * i / steps);
    for (int i = 0; i < steps; ++i) add(w * (steps - i) / steps, h);
    for (int i = 0; i < steps; ++i) add(0, h * (steps - i) / steps);
    return polygon;
}

json errors_json(const View& view, const std::vector<Polyline>& walls) {
    const ErrorMap map = error_map(view, walls, farthest_view);
    json cells = json::array();
    for (const ErrorCell& cell : map.cells) cells.push_back({rounded(cell.centre.x(), 1e-3), rounded(cell.centre.y(), 1e-3), rounded(cell.radius, 1e-4)});
    return {{"cell", rounded(map.cell, 1e-4)}, {"cells", cells}};
}

json shape_json(const Shape& shape) {
    if (const auto* box = std::get_if<Box>(&shape)) return {{"shape", "box"}, {"size", {box->length, box->width, box->height}}};
    const auto& cylinder = std::get<Cylinder>(shape);
    return {{"shape", "cylinder"}, {"size", {cylinder.diameter, cylinder.height}}};
}

/// What does not change of a camera.
json site_camera_json(const CameraPipeline& pipeline, const Site& site) {
    const CameraModel& model = pipeline.camera().model;
    json camera = {{"id", pipeline.id()}, {"width", model.width}, {"height", model.height}};
    if (const FixedCamera* fixed = pipeline.fixed()) {
        camera["position"] = point(fixed->view().position().head<2>());
        camera["view"] = field_of_view(fixed->view(), site.walls);
        camera["errors"] = errors_json(fixed->view(), site.walls);
    } else {
        camera["robot"] = site.robots[static_cast<std::size_t>(pipeline.robot())].id;
    }
    return camera;
}

/// Where the picture's lower left corner is, and how it is turned.
json plan_json(const SitePlan& plan, const PlanPicture& picture) {
    const Pose2& at = plan.map_from_plan;
    return {{"width", picture.width}, {"height", picture.height}, {"resolution", plan.resolution}, {"x", at.x}, {"y", at.y}, {"yaw", at.yaw}};
}

}  // namespace

std::string page_site_json(const SiteTracker& tracker, const PageSite& now) {
    const Site& described = tracker.site();
    json site = {{"version", now.version},   {"name", described.name},     {"walls", json::array()},   {"cameras", json::array()},
                 {"robots", json::object()}, {"landmarks", json::array()}, {"beacons", json::array()}, {"corners", json::array()}};
    for (const Polyline& line : described.walls) site["walls"].push_back(points_json(line));
    for (std::size_t c = 0; c < tracker.cameras(); ++c) site["cameras"].push_back(site_camera_json(tracker.pipeline(c), described));
    for (const SiteRobot& robot : described.robots) {
        site["robots"][robot.id] = shape_json(robot.shape);
        site["robots"][robot.id]["many"] = robot.many;
    }
    for (const SiteLandmark& landmark : described.landmarks) site["landmarks"].push_back({{"id", landmark.id}, {"points", points_json(map_points(landmark))}});
    site["zones"] = json::array();
    for (const SiteZone& zone : now.zones) site["zones"].push_back({{"id", zone.id}, {"border", points_json(zone.border)}});
    for (const SiteBeacon& beacon : described.beacons) site["beacons"].push_back({{"id", beacon.id}, {"position", point(beacon.position.head<2>())}});
    for (const SiteCorner& corner : described.corners) {
        constexpr double arm = 0.35;  // m, of its edges on the map
        const Eigen::Vector2d at = corner.position.head<2>();
        const auto along = [&](double angle) { return point(at + arm * Eigen::Vector2d(std::cos(angle), std::sin(angle))); };
        site["corners"].push_back({{"id", corner.id}, {"points", {along(corner.yaw), point(at), along(corner.yaw + corner.wall_angle)}}});
    }
    if (now.plan != nullptr) site["plan"] = plan_json(*described.plan, *now.plan);
    return json_line(site);
}

}  // namespace roomfix
