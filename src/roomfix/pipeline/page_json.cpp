// What the page is told: the site once, the state several times a second. Documented in docs/formats.md.
#include <cmath>
#include <nlohmann/json.hpp>

#include "roomfix/ceiling/lamps.hpp"
#include "roomfix/pipeline/site_runner.hpp"

namespace roomfix {
namespace {

using nlohmann::json;

constexpr double farthest_view = 15;  // m: a field of view is drawn no farther than this

double rounded(double value, double unit) { return std::round(value / unit) * unit; }

json point(const Eigen::Vector2d& p) { return {rounded(p.x(), 1e-4), rounded(p.y(), 1e-4)}; }

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

json shape_json(const Shape& shape) {
    if (const auto* box = std::get_if<Box>(&shape)) return {{"shape", "box"}, {"size", {box->length, box->width, box->height}}};
    const auto& cylinder = std::get<Cylinder>(shape);
    return {{"shape", "cylinder"}, {"size", {cylinder.diameter, cylinder.height}}};
}

}  // namespace

std::string SiteRunner::site_json() const {
    json site = {{"name", site_.name},         {"walls", json::array()},   {"cameras", json::array()}, {"robots", json::object()},
                 {"landmarks", json::array()}, {"beacons", json::array()}, {"corners", json::array()}};
    for (const Polyline& line : site_.walls) {
        json polyline = json::array();
        for (const auto& p : line) polyline.push_back(point(p));
        site["walls"].push_back(polyline);
    }
    for (const auto& post : posts_) {
        if (!post->observer) {
            const int robot = post->corners ? post->corners->robot() : post->locator->robot();
            site["cameras"].push_back({{"id", post->camera.id},
                                       {"width", post->camera.model.width},
                                       {"height", post->camera.model.height},
                                       {"robot", site_.robots[static_cast<std::size_t>(robot)].id}});
            continue;
        }
        const View& view = post->observer->view();
        site["cameras"].push_back({{"id", post->camera.id},
                                   {"width", view.model.width},
                                   {"height", view.model.height},
                                   {"position", point(view.position().head<2>())},
                                   {"view", field_of_view(view, site_.walls)}});
    }
    for (const SiteRobot& robot : site_.robots) {
        site["robots"][robot.id] = shape_json(robot.shape);
        site["robots"][robot.id]["many"] = robot.many;
    }
    for (const SiteLandmark& landmark : site_.landmarks) {
        json points = json::array();
        for (const auto& p : map_points(landmark)) points.push_back(point(p.head<2>()));
        site["landmarks"].push_back({{"id", landmark.id}, {"points", points}});
    }
    for (const SiteBeacon& beacon : site_.beacons) site["beacons"].push_back({{"id", beacon.id}, {"position", point(beacon.position.head<2>())}});
    for (const SiteCorner& corner : site_.corners) {
        constexpr double arm = 0.35;  // m, of its edges on the map
        const Eigen::Vector2d at = corner.position.head<2>();
        const auto along = [&](double angle) { return point(at + arm * Eigen::Vector2d(std::cos(angle), std::sin(angle))); };
        site["corners"].push_back({{"id", corner.id}, {"points", {along(corner.yaw), point(at), along(corner.yaw + corner.wall_angle)}}});
    }
    return site.dump();
}

/// What a camera that looks for corners saw: the corner's edges, with the walls' last, and lines that are none of them.
nlohmann::json SiteRunner::corner_json(const Post& post) const {
    json seen = {{"id", json()}, {"edges", json::array()}, {"rejected", json::array()}};
    const auto segment = [](const Eigen::Vector2f& from, const Eigen::Vector2f& to) {
        json line = json::array();
        for (const float v : {from.x(), from.y(), to.x(), to.y()}) line.push_back(rounded(static_cast<double>(v), 0.1));
        return line;
    };
    const CornerCameraResult& shown = post.shown_corner;
    for (const RejectedLine& line : shown.seen.rejected) seen["rejected"].push_back(segment(line.from, line.to));
    if (shown.seen.corners.empty()) return seen;
    const bool placed = !shown.located.places.empty();
    const CornerObservation& corner = shown.seen.corners[placed ? static_cast<std::size_t>(shown.located.places[0].observation) : 0];
    if (placed && shown.located.places[0].weight > likely) seen["id"] = post.corners->corner_name(shown);
    for (const EdgeSighting& edge : corner.edges) seen["edges"].push_back(segment(edge.ends[0], edge.ends[1]));
    return seen;
}

/// The circles on the floor plan that a robot's ranges draw around the beacons.
nlohmann::json SiteRunner::ranges_json(Nanoseconds time) const {
    json circles = json::array();
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        const SiteRobot& robot = site_.robots[r];
        for (const RangeObservation& range : ears_.near(static_cast<int>(r), time)) {
            const SiteBeacon& beacon = site_.beacons[static_cast<std::size_t>(range.beacon)];
            const double rise = beacon.position.z() - robot.receiver->position.z();
            const double radius = std::sqrt(std::max(range.range * range.range - rise * rise, 0.0));
            circles.push_back({{"robot", robot.id}, {"beacon", beacon.id}, {"radius", rounded(radius, 1e-3)}});
        }
    }
    return circles;
}

/// What a camera on a robot saw: landmarks with their points, spots that are none, lamps.
nlohmann::json SiteRunner::onboard_json(const Post& post) const {
    json seen = {{"landmarks", json::array()}, {"rejected", json::array()}, {"lamps", json::array()}};
    const auto names = post.locator->landmark_names(post.shown_onboard);
    for (std::size_t i = 0; i < names.size(); ++i) {
        json points = json::array();
        for (const auto& p : post.shown_onboard.seen.landmarks[i].points) points.push_back({rounded(p.pixel.x(), 0.1), rounded(p.pixel.y(), 0.1)});
        seen["landmarks"].push_back({{"id", names[i].empty() ? json() : json(names[i])}, {"points", points}});
    }
    for (const auto& spot : post.shown_onboard.seen.rejected) {
        seen["rejected"].push_back({rounded(static_cast<double>(spot.pixel.x()), 0.1), rounded(static_cast<double>(spot.pixel.y()), 0.1)});
    }
    if (!post.last.empty()) {
        for (const LampBox& lamp : find_lamps(post.last)) seen["lamps"].push_back({lamp.left, lamp.top, lamp.right, lamp.bottom});
    }
    return seen;
}

std::string SiteRunner::state_json(Nanoseconds time, const std::vector<Fix>& fixes) const {
    json state = {{"time", to_seconds(time)}, {"robots", json::array()}, {"cameras", json::array()}};
    for (const Fix& fix : fixes) {
        if (fix.status == FixStatus::none) continue;
        json robot = {{"id", fix.robot},
                      {"status", fix.status == FixStatus::ok ? "ok" : "coasting"},
                      {"x", rounded(fix.pose.x, 1e-4)},
                      {"y", rounded(fix.pose.y, 1e-4)},
                      {"sources", fix.sources}};
        robot["yaw"] = fix.yaw_known ? json(rounded(fix.pose.yaw, 1e-4)) : json();
        robot["cov"] = {fix.covariance(0, 0), fix.covariance(0, 1), fix.covariance(1, 1), fix.covariance(2, 2)};
        if (fix.identity < 0.999) robot["identity"] = rounded(fix.identity, 1e-3);
        state["robots"].push_back(robot);
    }
    for (const auto& post : posts_) {
        json camera = {{"id", post->state.id},         {"status", post->state.status},           {"message", post->state.message},
                       {"frames", post->state.frames}, {"rate", rounded(post->state.rate, 0.1)}, {"busy_ms", rounded(1e3 * post->state.busy, 0.01)},
                       {"outlines", json::array()}};
        for (const SilhouetteObservation& o : post->shown) {
            json outline = json::array();
            for (const auto& corner : o.outline)
                outline.push_back({rounded(static_cast<double>(corner.x()), 0.1), rounded(static_cast<double>(corner.y()), 0.1)});
            const std::string robot = site_.robots[static_cast<std::size_t>(o.robot)].id;
            camera["outlines"].push_back({{"robot", robot}, {"points", outline}, {"support", rounded(o.support, 0.01)}});
        }
        if (post->corners) camera["corner"] = corner_json(*post);
        if (post->locator) camera["seen"] = onboard_json(*post);
        state["cameras"].push_back(camera);
    }
    state["ranges"] = ranges_json(time);
    return state.dump();
}

}  // namespace roomfix
