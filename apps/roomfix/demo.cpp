#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "commands.hpp"
#include "log.hpp"
#include "roomfix/base/steady_now.hpp"
#include "roomfix/base/worker_pool.hpp"
#include "roomfix/connect/line_file.hpp"
#include "roomfix/pipeline/fix_file.hpp"
#include "roomfix/pipeline/page_sink.hpp"
#include "roomfix/pipeline/source_runner.hpp"
#include "roomfix/simulate/render_ahead.hpp"
#include "roomfix/simulate/scenario_renderer.hpp"
#include "roomfix/simulate/truth_rows.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string log_level = "info";
    WebOutput web;
    std::string fixes, truth;
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
std::vector<ScenarioRenderer> prepare(const Scenario& scenario, SiteTracker& tracker, std::uint64_t seed) {
    constexpr std::uint64_t background_frames = 30;
    std::vector<ScenarioRenderer> renderers;
    const auto progress = progress_bar("rendering the empty building");
    for (std::size_t c = 0; c < camera_count(scenario); ++c) {
        ScenarioRenderer& renderer = renderers.emplace_back(scenario, c, seed);
        if (c >= scenario.cameras.size()) continue;
        BackgroundLearner learner;
        ColourFrames levels;
        LumaImage frame;
        ColourImage small;
        for (std::uint64_t i = 0; i < background_frames; ++i) {
            renderer.render_empty(i, frame);
            learner.add(frame);
            shrink_grey(frame.view(), small);
            levels.add(small);
        }
        ColourBackground colour;
        colour.learn(levels.frames());
        tracker.set_background(c, learner.learn(), std::move(colour));
        progress(static_cast<double>(c + 1) / static_cast<double>(scenario.cameras.size()));
    }
    return renderers;
}

/// What all receivers hear between two times (s); `epoch` is time 0.
RangeBatch heard_between(const Scenario& scenario, double from, double to, Nanoseconds epoch, std::uint64_t seed) {
    RangeBatch heard;
    for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
        for (RangeObservation range : heard_ranges(scenario, r, from, to, seed)) {
            range.time += epoch;
            heard.ranges.push_back(range);
        }
    }
    return heard;
}

int demo(const Arguments& arguments) {
    const Scenario scenario = demo_scenario(arguments.seed);
    auto created = SiteTracker::create(scenario.site);
    if (!created) {
        log_error(created.error().message);
        return failed;
    }
    SiteTracker& tracker = **created;
    SourceRunner runner(tracker);
    if (!arguments.fixes.empty()) {
        auto file = FixFile::open(arguments.fixes);
        if (!file) {
            log_error(file.error().message);
            return bad_input;
        }
        runner.add_sink(std::move(*file), Overflow::drop_oldest);
    }
    std::optional<LineFile> truth;
    if (!arguments.truth.empty()) {
        auto file = LineFile::create(arguments.truth, truth_header);
        if (!file) {
            log_error(file.error().message);
            return bad_input;
        }
        truth = std::move(*file);
    }
    auto page = PageSink::serve(tracker, arguments.web, runner);
    if (!page) {
        log_error(page.error().message);
        return bad_input;
    }
    const int port = (*page)->port();
    runner.add_sink(std::move(*page), Overflow::newest_only);
    auto renderers = prepare(scenario, tracker, arguments.seed);
    const Mishaps mishaps;
    ScenarioRenderer knocked(scenario, mishaps.bumped, arguments.seed, radians(0.8));
    log_info(
        fmt::format("Five robots drive through a rendered building, found by three cameras on the walls, landmarks on the ceiling, a room's corners,\n"
                    "beacons and their wheels. Two of them look the same, and one passes through a room that no camera sees. From 0:30 to 0:40 of every\n"
                    "90 seconds camera {} freezes, from 0:55 to 1:15 camera {} is knocked out of its direction.\n"
                    "Open http://{}:{} in a browser. Ctrl-C ends the demo.",
                    scenario.cameras[mishaps.freezing].id, scenario.cameras[mishaps.bumped].id, arguments.web.host, port));

    const auto start = std::chrono::steady_clock::now();
    const Nanoseconds epoch = system_now();
    const auto now = [start] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    RenderAhead pictures(renderers.size(), scenario.frame_rate, now, [&](std::size_t c, double time, std::uint64_t number, LumaImage& frame) {
        if (c == mishaps.freezing && mishaps.frozen(time) && !frame.empty()) return;
        ScenarioRenderer& renderer = c == mishaps.bumped && mishaps.is_bumped(time) ? knocked : renderers[c];
        renderer.render(time, number, frame);
    });
    std::vector<ColourImage> small(scenario.cameras.size());  // of the fixed ones
    WorkerPool pool(hardware_threads());
    tracker.measure_latency({steady_now(), system_now(), 1});
    double heard_until = 0;
    std::vector<std::pair<int, WheelSimulator>> wheels;
    for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
        if (scenario.robots[r].robot.odometry) wheels.emplace_back(static_cast<int>(r), wheels_of(scenario, r, arguments.seed));
    }
    while (!stop_requested()) {
        const RenderAhead::Moment moment = pictures.take();
        if (arguments.seconds > 0 && moment.time > arguments.seconds) break;
        std::this_thread::sleep_until(start + std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(moment.time)));
        if (truth) {
            truth->add(truth_rows(scenario, moment.time, epoch + from_seconds(moment.time)));
            if (auto written = truth->flush(); !written) {
                log_error(written.error().message);
                return failed;
            }
        }
        tracker.process(heard_between(scenario, heard_until, moment.time, epoch, arguments.seed));
        heard_until = moment.time;
        OdometryBatch driven;
        for (auto& [robot, wheel] : wheels) {
            for (const WheelPose& pose : wheel.until(moment.time)) driven.poses.push_back({epoch + from_seconds(pose.time), robot, pose.pose});
        }
        tracker.process(driven);
        std::vector<CameraFrame> seen;
        for (std::size_t c = 0; c < moment.frames.size(); ++c) {
            if (c < small.size()) shrink_grey(moment.frames[c].view(), small[c]);
            seen.push_back({c, {moment.frames[c], c < small.size() ? &small[c] : nullptr}, epoch + from_seconds(moment.time)});
        }
        (void)tracker.process(seen, pool);
    }
    log_info(tracker.stage_times().text());
    const auto written = runner.finish_sinks();
    if (written) return done;
    log_error(written.error().message);
    return failed;
}

}  // namespace

void add_demo(Command& program) {
    Command command = program.add_command("demo", "a rendered building with robots, found live, on a map in the browser");
    auto arguments = std::make_shared<Arguments>();
    command.option("--host", arguments->web.host, "address to serve the page on").show_default();
    command.option("--port", arguments->web.port, "port of the page; 0 picks a free one").show_default().range(0, 65535);
    command.flag("--insecure", arguments->web.insecure, "with --host: whoever reaches this machine may look, without encryption and token");
    command.option("--fixes", arguments->fixes, "file for the fixes; - for stdout");
    command.option("--truth", arguments->truth, "file for where the robots really are, to set the fixes beside it with evaluate");
    command.option("--seconds", arguments->seconds, "end by itself after that long");
    command.option("--seed", arguments->seed, "of noise, clicks and sizes").show_default();
    add_log_level(command, arguments->log_level);
    command.footer(
        "Example: roomfix demo --port 8090\nBeside its truth: roomfix demo --seconds 60 --fixes fixes.jsonl --truth truth.csv && roomfix evaluate fixes.jsonl "
        "--truth truth.csv");
    command.on_run([=] { return with_log(arguments->log_level, [&] { return demo(*arguments); }); });
}

}  // namespace roomfix
