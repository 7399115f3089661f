#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include "commands.hpp"
#include "roomfix/pipeline/site_runner.hpp"
#include "roomfix/simulate/scenario.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string host = "127.0.0.1";
    int port = 8080;
    std::string fixes;
    double seconds = 0;
    std::uint64_t seed = 1;
};

/// What goes wrong in every round of `period` seconds, so that one can watch the tracker cope.
struct Mishaps {
    double period = 90;
    std::size_t freezing = 1;  // this camera repeats a picture ...
    double freeze_from = 30, freeze_to = 40;
    std::size_t bumped = 0;  // ... and this one is knocked out of its direction, until somebody puts it back
    double bump_from = 55, bump_to = 75;

    static bool within(double time, double period, double from, double to) {
        const double now = std::fmod(time, period);
        return now >= from && now < to;
    }
    bool frozen(double time) const { return within(time, period, freeze_from, freeze_to); }
    bool is_bumped(double time) const { return within(time, period, bump_from, bump_to); }
};

/// The rooms without robots, rendered and learned.
std::vector<CameraRenderer> prepare(const Scenario& scenario, SiteRunner& room, std::uint64_t seed) {
    constexpr int background_frames = 30;
    std::vector<CameraRenderer> renderers;
    const auto progress = progress_bar("rendering the empty building");
    for (std::size_t c = 0; c < scenario.cameras.size(); ++c) {
        renderers.emplace_back(scenario.scene, scenario.cameras[c].truth, scenario.cameras[c].sensor, seed * 31 + c);
        BackgroundLearner learner;
        ColourFrames levels;
        LumaImage frame;
        ColourImage small;
        for (int i = 0; i < background_frames; ++i) {
            renderers[c].render({}, light_at(-0.1 * i, seed + c), 1'000'000 + static_cast<std::uint64_t>(i), frame);
            learner.add(frame);
            shrink_grey(frame.view(), small);
            levels.add(small);
        }
        ColourBackground colour;
        colour.learn(levels.frames());
        room.set_background(c, learner.learn(), std::move(colour));
        progress(static_cast<double>(c + 1) / static_cast<double>(scenario.cameras.size()));
    }
    return renderers;
}

int demo(const Arguments& arguments) {
    const Scenario scenario = demo_scenario(arguments.seed);
    auto runner = SiteRunner::create(scenario.site);
    if (!runner) {
        complain(runner.error().message);
        return failed;
    }
    SiteRunner& room = **runner;
    if (!arguments.fixes.empty()) {
        if (auto opened = room.write_fixes_to(arguments.fixes); !opened) {
            complain(opened.error().message);
            return bad_input;
        }
    }
    if (auto served = room.serve_page(arguments.host, arguments.port); !served) {
        complain(served.error().message);
        return bad_input;
    }
    const auto renderers = prepare(scenario, room, arguments.seed);
    std::vector<CeilingRenderer> up_renderers;
    for (const ScenarioUpCamera& camera : scenario.up_cameras) {
        up_renderers.emplace_back(camera.truth.model, camera.sensor, camera.glare, arguments.seed * 37 + up_renderers.size());
    }
    std::vector<RoomRenderer> eye_renderers;
    const Mishaps mishaps;
    View knocked = scenario.cameras[mishaps.bumped].truth;
    knocked.map_from_camera.pose.linear() = exponential_rotation({0, 0, radians(0.8)}) * knocked.map_from_camera.pose.linear();
    const CameraRenderer knocked_renderer(scenario.scene, knocked, scenario.cameras[mishaps.bumped].sensor, arguments.seed * 31 + mishaps.bumped);
    for (const ScenarioEye& eye : scenario.eyes) eye_renderers.emplace_back(eye.truth.model, eye.sensor, eye.glare, arguments.seed * 41 + eye_renderers.size());
    say(
        fmt::format("Five robots drive through a rendered building, found by three cameras on the walls, landmarks on the ceiling, a room's corners,\n"
                    "beacons and their wheels. Two of them look the same, and one passes through a room that no camera sees. From 0:30 to 0:40 of every\n"
                    "90 seconds camera {} freezes, from 0:55 to 1:15 camera {} is knocked out of its direction.\n"
                    "Open http://{}:{} in a browser. Ctrl-C ends the demo.",
                    scenario.cameras[mishaps.freezing].id, scenario.cameras[mishaps.bumped].id, arguments.host, room.page_port()));

    const auto start = std::chrono::steady_clock::now();
    const Nanoseconds epoch = system_now();
    std::vector<Solid> solids;
    std::vector<LumaImage> frames(renderers.size() + up_renderers.size() + eye_renderers.size());  // fixed, looking up, looking for corners
    std::vector<ColourImage> small(renderers.size());                                              // of the fixed ones
    WorkerPool pool(hardware_threads());
    room.measure_latency();
    double heard_until = 0;
    std::vector<std::pair<int, WheelSimulator>> wheels;
    for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
        if (scenario.robots[r].robot.odometry) wheels.emplace_back(static_cast<int>(r), wheels_of(scenario, r, arguments.seed));
    }
    for (std::uint64_t i = 0; !stop_requested(); ++i) {
        const auto elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start);
        const double time = elapsed.count();
        if (arguments.seconds > 0 && time > arguments.seconds) break;
        solids.clear();
        for (const ScenarioRobot& robot : scenario.robots) {
            const auto parts = robot_solids(robot.robot.shape, robot.look, robot_pose(robot, time));
            solids.insert(solids.end(), parts.begin(), parts.end());
        }
        // Rendered side by side, and looked at side by side.
        const bool frozen = mishaps.frozen(time) && !frames[mishaps.freezing].empty();
        const std::size_t ups = renderers.size(), eyes = ups + up_renderers.size();
        const std::uint64_t light = arguments.seed;
        pool.run(static_cast<int>(frames.size()), [&](int job) {
            const auto c = static_cast<std::size_t>(job);
            if (c >= eyes) {
                const Eigen::Isometry3d map_from_camera = eye_pose(scenario, scenario.eyes[c - eyes], time);
                eye_renderers[c - eyes].render(scenario.room, map_from_camera, light_at(time, light + 80 + c - eyes), i, frames[c]);
            } else if (c >= ups) {
                const ScenarioUpCamera& camera = scenario.up_cameras[c - ups];
                const Eigen::Isometry3d map_from_camera = map_from_robot(robot_pose(scenario.robots[camera.robot], time)) * camera.truth.robot_from_camera.pose;
                up_renderers[c - ups].render(scenario.ceiling, map_from_camera, light_at(time, light + 50 + c - ups), i, frames[c]);
            } else if (c != mishaps.freezing || !frozen) {
                const CameraRenderer& renderer = c == mishaps.bumped && mishaps.is_bumped(time) ? knocked_renderer : renderers[c];
                renderer.render(solids, light_at(time, light + c), i, frames[c]);
                shrink_grey(frames[c].view(), small[c]);
            }
        });
        RangeBatch heard;
        for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
            for (RangeObservation range : heard_ranges(scenario, r, heard_until, time, arguments.seed)) {
                range.time += epoch;
                heard.ranges.push_back(range);
            }
        }
        heard_until = time;
        room.hear(heard);
        OdometryBatch driven;
        for (auto& [robot, wheel] : wheels) {
            for (const WheelPose& pose : wheel.until(time)) driven.poses.push_back({epoch + from_seconds(pose.time), robot, pose.pose});
        }
        room.drive(driven);
        std::vector<CameraFrame> seen;
        for (std::size_t c = 0; c < frames.size(); ++c) seen.push_back({c, {frames[c], c < small.size() ? &small[c] : nullptr}, epoch + from_seconds(time)});
        (void)room.feed(seen, pool);
        const double next = static_cast<double>(static_cast<std::int64_t>(time * scenario.frame_rate) + 1) / scenario.frame_rate;
        std::this_thread::sleep_until(start + std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(next)));
    }
    say(room.stage_times().text());
    return done;
}

}  // namespace

void add_demo(CLI::App& app, int& exit_code) {
    auto* command = app.add_subcommand("demo", "a rendered building with robots, found live, on a map in the browser");
    auto arguments = std::make_shared<Arguments>();
    command->add_option("--host", arguments->host, "address to serve the page on")->capture_default_str();
    command->add_option("--port", arguments->port, "port of the page; 0 picks a free one")->capture_default_str()->check(CLI::Range(0, 65535));
    command->add_option("--fixes", arguments->fixes, "file for the fixes; - for stdout");
    command->add_option("--seconds", arguments->seconds, "end by itself after that long");
    command->add_option("--seed", arguments->seed, "of noise, clicks and sizes")->capture_default_str();
    command->footer("Example: roomfix demo --port 8090");
    command->callback([=, &exit_code] { exit_code = demo(*arguments); });
}

}  // namespace roomfix
