// What the page is told: the site once, the state several times a second. Documented in docs/formats.md.
#include "roomfix/pipeline/page_sink.hpp"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "roomfix/connect/fix_json.hpp"
#include "roomfix/connect/json_text.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/pipeline/camera_pipeline.hpp"
#include "roomfix/pipeline/error_map.hpp"
#include "roomfix/pipeline/live_senses.hpp"
#include "roomfix/pipeline/metrics.hpp"
#include "roomfix/pipeline/page_numbers.hpp"
#include "roomfix/pipeline/source_runner.hpp"

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

json pixel(const Eigen::Vector2f& p) { return {rounded(static_cast<double>(p.x()), 0.1), rounded(static_cast<double>(p.y()), 0.1)}; }

json segment(const DrawnLine& line) {
    json ends = pixel(line.from);
    for (const json& to : pixel(line.to)) ends.push_back(to);
    return ends;
}

json id_or_null(const std::string& id) { return id.empty() ? json() : json(id); }

/// What was seen in a camera's frame, as fields of its state.
void add_drawing(const ShownFrame& frame, json& state) {
    Drawing drawing = frame.drawing;
    add_lamps(drawing, frame.picture);
    state["outlines"] = json::array();
    for (const DrawnOutline& outline : drawing.outlines) {
        json points = json::array();
        for (const Eigen::Vector2f& p : outline.points) points.push_back(pixel(p));
        state["outlines"].push_back({{"robot", outline.robot}, {"points", points}, {"support", rounded(outline.support, 0.01)}});
    }
    if (drawing.shows_landmarks || !drawing.landmarks.empty()) {
        json seen = {{"landmarks", json::array()}, {"rejected", json::array()}, {"lamps", json::array()}};
        for (const DrawnLandmark& landmark : drawing.landmarks) {
            json points = json::array();
            for (const Eigen::Vector2f& p : landmark.points) points.push_back(pixel(p));
            seen["landmarks"].push_back({{"id", id_or_null(landmark.id)}, {"points", points}});
        }
        for (const Eigen::Vector2f& spot : drawing.rejected_spots) seen["rejected"].push_back(pixel(spot));
        for (const auto& lamp : drawing.lamps) seen["lamps"].push_back(lamp);
        state["seen"] = seen;
    }
    if (drawing.shows_corners) {
        json seen = {{"id", json()}, {"edges", json::array()}, {"rejected", json::array()}};
        for (const DrawnLine& line : drawing.rejected_lines) seen["rejected"].push_back(segment(line));
        if (drawing.corner) {
            seen["id"] = id_or_null(drawing.corner->id);
            for (const DrawnLine& edge : drawing.corner->edges) seen["edges"].push_back(segment(edge));
        }
        state["corner"] = seen;
    }
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

json robot_json(const Fix& fix, const std::vector<std::string>& zones) {
    json robot = {{"id", fix.robot},
                  {"status", fix.unknown ? "unknown" : name_of(fix.status)},
                  {"x", rounded(fix.pose.x, 1e-4)},
                  {"y", rounded(fix.pose.y, 1e-4)},
                  {"sources", fix.sources}};
    robot["yaw"] = fix.yaw_known ? json(rounded(fix.pose.yaw, 1e-4)) : json();
    robot["cov"] = {fix.covariance(0, 0), fix.covariance(0, 1), fix.covariance(1, 1), fix.covariance(2, 2)};
    if (fix.identity < 0.999) robot["identity"] = rounded(fix.identity, 1e-3);
    if (!zones.empty()) robot["zones"] = zones;
    return robot;
}

/// How a camera is doing; `frame`: what it saw last, if anything.
json camera_json(const CameraState& state, const ShownFrame* frame) {
    json camera = {{"id", state.id},         {"status", state.status},           {"message", state.message},
                   {"frames", state.frames}, {"rate", rounded(state.rate, 0.1)}, {"busy_ms", rounded(1e3 * state.busy, 0.01)}};
    if (state.dropped > 0) camera["dropped"] = state.dropped;
    if (!state.note.empty()) camera["note"] = state.note;
    if (frame) {
        add_drawing(*frame, camera);
    } else {
        camera["outlines"] = json::array();
    }
    return camera;
}

/// Where readings come from and fixes go to.
void add_connections(const SourceRunner& runner, json& state) {
    for (const SinkState& sink : runner.sink_states()) {
        json told = {{"name", sink.name}, {"status", sink.status}, {"message", sink.message}};
        if (sink.lost > 0) told["lost"] = sink.lost;
        state["sinks"].push_back(told);
    }
    for (const SenseState& sense : runner.sense_states()) {
        state["senses"].push_back({{"source", sense.source}, {"message", sense.message}, {"readings", sense.readings}});
    }
}

}  // namespace

std::string PageSink::site_json() const {
    const Site& described = tracker_.site();
    json site = {{"name", described.name},     {"walls", json::array()},   {"cameras", json::array()}, {"robots", json::object()},
                 {"landmarks", json::array()}, {"beacons", json::array()}, {"corners", json::array()}};
    for (const Polyline& line : described.walls) site["walls"].push_back(points_json(line));
    for (std::size_t c = 0; c < tracker_.cameras(); ++c) site["cameras"].push_back(site_camera_json(tracker_.pipeline(c), described));
    for (const SiteRobot& robot : described.robots) {
        site["robots"][robot.id] = shape_json(robot.shape);
        site["robots"][robot.id]["many"] = robot.many;
    }
    for (const SiteLandmark& landmark : described.landmarks) site["landmarks"].push_back({{"id", landmark.id}, {"points", points_json(map_points(landmark))}});
    site["zones"] = json::array();
    for (const SiteZone& zone : described.zones) site["zones"].push_back({{"id", zone.id}, {"border", points_json(zone.border)}});
    for (const SiteBeacon& beacon : described.beacons) site["beacons"].push_back({{"id", beacon.id}, {"position", point(beacon.position.head<2>())}});
    for (const SiteCorner& corner : described.corners) {
        constexpr double arm = 0.35;  // m, of its edges on the map
        const Eigen::Vector2d at = corner.position.head<2>();
        const auto along = [&](double angle) { return point(at + arm * Eigen::Vector2d(std::cos(angle), std::sin(angle))); };
        site["corners"].push_back({{"id", corner.id}, {"points", {along(corner.yaw), point(at), along(corner.yaw + corner.wall_angle)}}});
    }
    return json_line(site);
}

/// The circle on the floor plan that a range draws around its beacon.
static json range_json(const Site& site, const RangeObservation& range) {
    const SiteBeacon& beacon = site.beacons[static_cast<std::size_t>(range.beacon)];
    const SiteRobot& robot = site.robots[static_cast<std::size_t>(range.robot)];
    const double rise = beacon.position.z() - robot.receiver()->position.z();
    const double radius = std::sqrt(std::max(range.range * range.range - rise * rise, 0.0));
    return {{"robot", robot.id}, {"beacon", beacon.id}, {"radius", rounded(radius, 1e-3)}};
}

std::string PageSink::state_json(const FixBatch& batch) const {
    const SiteSnapshot site = tracker_.snapshot(batch.time);
    json state = {{"time", to_seconds(batch.time)}, {"robots", json::array()}, {"cameras", json::array()}, {"ranges", json::array()}};
    for (const Fix& fix : batch.all) {
        if (fix.status != FixStatus::none) state["robots"].push_back(robot_json(fix, zones_.zones_of(fix.robot)));
    }
    for (std::size_t c = 0; c < site.cameras.size(); ++c) state["cameras"].push_back(camera_json(site.cameras[c], site.frames[c].get()));
    for (const RangeObservation& range : site.ranges) state["ranges"].push_back(range_json(tracker_.site(), range));
    if (runner_) add_connections(*runner_, state);
    const StageTimes& times = tracker_.stage_times();
    for (std::size_t s = 0; s < stages; ++s) {
        const StageSummary stage = times.summary(static_cast<Stage>(s));
        if (stage.count == 0) continue;
        state["stages"][name_of(static_cast<Stage>(s))] = {rounded(1e3 * stage.median, 0.01), rounded(1e3 * stage.p95, 0.01), rounded(1e3 * stage.p99, 0.01)};
    }
    return json_line(state);
}

std::vector<std::uint8_t> PageSink::picture_of(const std::string& camera) const {
    const auto shown = tracker_.shown_frame(camera);
    return shown ? encode_jpeg(shown->picture, 80) : std::vector<std::uint8_t>();
}

std::string PageSink::metrics() const {
    std::vector<Fix> robots;
    {
        const std::lock_guard lock(mutex_);
        robots = newest_;
    }
    return metrics_text(tracker_, robots, runner_ ? runner_->sink_states() : std::vector<SinkState>());
}

Result<std::unique_ptr<PageSink>> PageSink::serve(SiteTracker& tracker, const WebOutput& web, const SourceRunner* runner) {
    auto access = web_access(web, tracker.site(), "the page");
    if (!access) return access.error();
    std::unique_ptr<PageSink> page(new PageSink(tracker, runner));
    tracker.keep_frames();
    page->server_.set_site(page->site_json());
    page->server_.set_picture_source([shown = page.get()](const std::string& camera) { return shown->picture_of(camera); });
    page->server_.add_route("/metrics", [shown = page.get()](const WebParameters&) { return WebAnswer{200, "text/plain; version=0.0.4", shown->metrics()}; });
    if (auto started = page->server_.start(*access); !started) return started.error();
    return page;
}

Result<void> PageSink::give(const FixBatch& batch) {
    constexpr auto least_interval = std::chrono::milliseconds(60);  // a screen needs no more
    {
        const std::lock_guard lock(mutex_);
        newest_ = batch.all;
    }
    for (const Fix& fix : batch.all) {
        if (!fix.unknown) (void)zones_.update(fix);
    }
    server_.publish(state_json(batch));
    std::this_thread::sleep_for(least_interval);
    return {};
}

}  // namespace roomfix
