// The state that the page is told several times a second. Documented in docs/openapi.json.
#include "roomfix/pipeline/page_sink.hpp"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "roomfix/base/steady_now.hpp"
#include "roomfix/connect/fix_json.hpp"
#include "roomfix/connect/json_text.hpp"
#include "roomfix/connect/zone_answer.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/pipeline/camera_pipeline.hpp"
#include "roomfix/pipeline/live_senses.hpp"
#include "roomfix/pipeline/metrics.hpp"
#include "roomfix/pipeline/page_numbers.hpp"
#include "roomfix/pipeline/page_site.hpp"
#include "roomfix/pipeline/source_runner.hpp"

namespace roomfix {
namespace {

using nlohmann::json;

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

/// Who entered and left zones last.
json events_json(const std::vector<ZoneEvent>& events) {
    json list = json::array();
    for (const ZoneEvent& event : events) {
        list.push_back({{"time", to_seconds(event.time)}, {"robot", event.robot}, {"zone", event.zone}, {"event", event.entered ? "enter" : "leave"}});
    }
    return list;
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
    json state = {{"time", to_seconds(batch.time)}, {"site", site_version_}, {"robots", json::array()}, {"cameras", json::array()}, {"ranges", json::array()}};
    for (const Fix& fix : batch.all) {
        if (fix.status != FixStatus::none) state["robots"].push_back(robot_json(fix, batch.zones_of(fix.robot)));
    }
    for (std::size_t c = 0; c < site.cameras.size(); ++c) state["cameras"].push_back(camera_json(site.cameras[c], site.frames[c].get()));
    for (const RangeObservation& range : site.ranges) state["ranges"].push_back(range_json(tracker_.site(), range));
    add_connections(runner_, state);
    if (const auto events = runner_.zone_events(); !events.empty()) state["zone_events"] = events_json(events);
    const StageTimes& times = tracker_.stage_times();
    for (std::size_t s = 0; s < stages; ++s) {
        const StageSummary stage = times.summary(static_cast<Stage>(s));
        if (stage.count == 0) continue;
        state["stages"][name_of(static_cast<Stage>(s))] = {rounded(1e3 * stage.median, 0.01), rounded(1e3 * stage.p95, 0.01), rounded(1e3 * stage.p99, 0.01)};
    }
    return json_line(state);
}

WebAnswer PageSink::picture_of(const std::string& camera) const {
    const auto shown = tracker_.shown_frame(camera);
    if (!shown) return {404, "text/plain", "no picture of this camera yet\n"};
    const auto bytes = encode_jpeg(shown->picture, 80);
    return {200, "image/jpeg", {bytes.begin(), bytes.end()}};
}

WebAnswer PageSink::robot(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    for (const Fix& fix : newest_.all) {
        if (fix.robot != id) continue;
        json robot = {{"id", id}, {"status", "none"}, {"reason", fix.reason}};
        if (fix.status != FixStatus::none) robot = robot_json(fix, newest_.zones_of(id));
        robot["time"] = to_seconds(fix.time);
        return {200, "application/json", json_line(robot)};
    }
    return {404, "text/plain", "nothing is known of such a robot\n"};
}

std::string PageSink::metrics() const {
    std::vector<Fix> robots;
    {
        const std::lock_guard lock(mutex_);
        robots = newest_.all;
    }
    return metrics_text(tracker_, robots, runner_.sink_states());
}

void PageSink::add_routes(const std::string& site_file) {
    server_.add_route("GET /api/cameras/{id}.jpg", [this](const WebQuestion& question) { return picture_of(question.id); });
    server_.add_route("GET /api/robots/{id}", [this](const WebQuestion& question) { return robot(question.id); });
    server_.add_route("GET /metrics", [this](const WebQuestion&) { return WebAnswer{200, "text/plain; version=0.0.4", metrics()}; });
    if (plan_) server_.add_route("GET /api/plan.png", [this](const WebQuestion&) { return WebAnswer{200, "image/png", plan_->png}; });
    if (site_file.empty()) return;
    const auto editor = std::make_shared<ZoneEditor>(site_file);
    server_.add_route("PUT /api/zones/{id}", [editor](const WebQuestion& question) { return editor->put(question); });
    server_.add_route("DELETE /api/zones/{id}", [editor](const WebQuestion& question) { return editor->remove(question); });
}

Result<std::unique_ptr<PageSink>> PageSink::serve(SiteTracker& tracker, const WebOutput& web, const SourceRunner& runner, const std::string& site_file) {
    auto access = web_access(web, tracker.site(), "the page");
    if (!access) return access.error();
    std::unique_ptr<PageSink> page(new PageSink(tracker, runner));
    if (const auto& plan = tracker.site().plan) {
        auto picture = load_plan_picture(tracker.site(), *plan);
        if (!picture) return Error{"plan: " + picture.error().message};
        page->plan_ = std::move(*picture);
    }
    tracker.keep_frames();
    page->show_site();
    page->add_routes(site_file);
    if (auto started = page->server_.start(*access); !started) return started.error();
    return page;
}

void PageSink::show_history(HistoryAnswerers answerers) {
    server_.add_route("GET /api/history", std::move(answerers.fixes));
    server_.add_route("GET /api/history/zones", std::move(answerers.zone_events));
}

/// With the zones of now. Those who look see by its number that there is something new.
void PageSink::show_site() {
    auto [zones, version] = runner_.zones();
    zones_version_ = version;
    site_version_ = system_now() / 1'000'000;
    server_.set_site(page_site_json(tracker_, {site_version_, std::move(zones), plan_ ? &*plan_ : nullptr}));
}

Result<void> PageSink::give(const FixBatch& batch) {
    constexpr auto least_interval = std::chrono::milliseconds(60);  // a screen needs no more
    {
        const std::lock_guard lock(mutex_);
        newest_ = batch;
    }
    if (runner_.zones().second != zones_version_) show_site();
    server_.publish(state_json(batch));
    std::this_thread::sleep_for(least_interval);
    return {};
}

}  // namespace roomfix
