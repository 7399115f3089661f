#include "run_site.hpp"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "commands.hpp"
#include "log.hpp"
#include "roomfix/base/worker_pool.hpp"
#include "roomfix/estimate/tracker.hpp"
#include "roomfix/pipeline/fix_file.hpp"
#include "roomfix/pipeline/history_sink.hpp"
#include "roomfix/pipeline/page_sink.hpp"
#include "roomfix/pipeline/session_content.hpp"
#include "roomfix/pipeline/session_recorder.hpp"
#include "roomfix/pipeline/site_sinks.hpp"
#include "terminal.hpp"

namespace roomfix {

void add_recording_options(Command& command, std::vector<std::string>& background, int& threads) {
    threads = hardware_threads();
    command.repeatable("--background", background, "picture, folder or video to learn the background from, for all cameras");
    command.option("--threads", threads, "that look at frames side by side; the result is the same with any number").show_default().range(1, 256);
}

BackgroundListener background_on_terminal() {
    BackgroundListener listener;
    listener.progress = [](const SiteCamera& camera) { return progress_bar("learning the background of " + camera.id); };
    listener.none = [](const SiteCamera& camera) { log_info(fmt::format("camera {}: no background given; learning it while running", camera.id)); };
    return listener;
}

static void log_status(const CameraState& camera) {
    if (camera.status == "ok") log_info(fmt::format("camera {} is ok again", camera.id));
    if (camera.status == "ok" || camera.status == "ended") return;
    log_warning(fmt::format("camera {} ({}): {}", camera.id, camera.status, camera.message));
}

/// What a run was like, for whoever started it.
static void say_what_happened(SiteTracker& tracker, const SourceRunner& runner, std::size_t fixes) {
    for (const CameraState& state : tracker.camera_states()) {
        const std::string dropped = state.dropped > 0 ? fmt::format(", {} not looked at since this machine is too slow", state.dropped) : "";
        log_info(fmt::format("camera {}: {} frames, {:.2f} ms each, {} bad{}; {}", state.id, state.frames, 1e3 * state.busy, state.bad_frames, dropped,
                             state.message));
        if (!state.note.empty()) log_info(fmt::format("camera {}: {}", state.id, state.note));
    }
    if (tracker.stage_times().summary(Stage::moment).count > 0) log_info(tracker.stage_times().text());
    tracker.finish_line_problems();
    for (const std::string& suspicion : runner.suspicious_inputs()) log_warning("look at this: " + suspicion);
    const TrackerCounts counts = tracker.tracker_counts();
    if (counts.late > 0) log_warning(fmt::format("{} observations came more than a second late and were not used", counts.late));
    if (counts.impossible > 0) log_warning(fmt::format("{} observations had impossible values and were not used", counts.impossible));
    if (counts.strayed > 0) log_warning(fmt::format("{} observations had times far from all others and were not used", counts.strayed));
    for (const SinkState& sink : runner.sink_states()) {
        if (sink.lost > 0) log_warning(fmt::format("{}: {} messages were lost", sink.name, sink.lost));
    }
    log_info(fmt::format("{} fixes given", fixes));
    for (const std::string& reason : tracker.robots_not_found()) log_warning("without a fix at the end: " + reason);
}

/// The recording that was asked for; null: none was.
static Result<std::unique_ptr<SessionRecorder>> start_recording(const SiteTracker& tracker, const RunOptions& options) {
    if (options.record.folder.empty()) return std::unique_ptr<SessionRecorder>();
    auto content = session_content(tracker, options.record.site_file, options.background);
    if (!content) return content.error();
    return SessionRecorder::start({options.record.folder, options.record.limits, options.run.speed == 0, log_warning}, std::move(*content));
}

/// Ends the recording, if there is one, and says what it holds.
static Result<void> finish_recording(const std::string& folder, SessionRecorder* recorder) {
    if (recorder == nullptr) return {};
    auto finished = recorder->finish();
    const RecordingState state = recorder->state();
    log_info(fmt::format("recorded to {}: {} frames, {:.1f} MB", folder, state.frames, 1e-6 * static_cast<double>(state.bytes)));
    return finished;
}

/// The file of fixes, as the options or the site file name it; null: none is.
static Result<std::unique_ptr<FixFile>> open_fix_file(const Site& site, const RunOptions& options) {
    if (!options.fixes.empty()) return FixFile::open(options.fixes, options.append);
    constexpr bool append = true;  // a service that is started again goes on
    if (!site.outputs.jsonl.empty()) return FixFile::open(resolved_path(site, site.outputs.jsonl), append);
    return std::unique_ptr<FixFile>();
}

/// Says where fixes go.
static Result<void> open_outputs(SourceRunner& runner, SiteTracker& tracker, Overflow overflow) {
    if (auto added = add_site_sinks(runner, tracker, overflow, log_warning); !added) return added;
    for (const SinkState& sink : runner.sink_states()) {
        if (sink.message.empty()) {
            log_info("fixes go to: " + sink.name);
        } else {
            log_warning(fmt::format("{}: {}; it is tried again", sink.name, sink.message));
        }
    }
    return {};
}

/// Last of all sinks: it asks how the others fare.
static Result<void> open_page(SourceRunner& runner, SiteTracker& tracker, const RunOptions& options) {
    const Outputs& outputs = tracker.site().outputs;
    WebOutput web = outputs.web.value_or(WebOutput{});
    if (!options.host.empty()) web.host = options.host;
    if (options.port >= 0) web.port = options.port;
    web.insecure = web.insecure || options.insecure;
    auto page = PageSink::serve(tracker, web, runner, options.watch ? options.record.site_file : "");
    if (!page) return page.error();
    if (options.outputs && outputs.history) {
        auto answerers = history_answerers(tracker.site());
        if (!answerers) return answerers.error();
        (*page)->show_history(std::move(*answerers));
    }
    log_info(fmt::format("the map is at http{}://{}:{}", web.tls ? "s" : "", web.host, (*page)->port()));
    runner.add_sink(std::move(*page), Overflow::newest_only);
    return {};
}

/// Zones that are drawn while it runs are taken up, as long as the result is kept.
static std::shared_ptr<void> follow_zones(SiteWatch* watch, SourceRunner& runner) {
    if (watch == nullptr) return nullptr;
    watch->on_zones([&runner](const std::vector<SiteZone>& zones) {
        runner.set_zones(zones);
        log_info("the zones were changed");
    });
    return {nullptr, [watch](void*) { watch->on_zones({}); }};
}

/// The best way after the fact, said where it is not.
static std::vector<Fix> smoothed(const SiteTracker& tracker, const std::vector<Fix>& fixes, const SmootherSettings& settings) {
    Smoothed best = smooth(tracker.tracker(), fixes, settings, progress_bar("smoothing"));
    for (const Unsettled& part : best.unsettled) {
        log_warning(fmt::format("{}: smoothing did not settle between {:.1f} s and {:.1f} s: the fixes of that time are the tracker's", part.robot,
                                to_seconds(part.from), to_seconds(part.to)));
    }
    return std::move(best.fixes);
}

/// With the exit code of what went wrong before anything ran.
static int give_up(const Error& error) {
    log_error(error.message);
    return bad_input;
}

int run_site(const Site& site, const RunOptions& options) {
    auto created = SiteTracker::create(site);
    if (!created) return give_up(created.error());
    SiteTracker& tracker = **created;
    tracker.on_camera_status(log_status);
    tracker.on_line_problem([](const std::string& problem) { log_warning("not used: " + problem); });
    if (auto learned = learn_backgrounds(tracker, options.background, background_on_terminal()); !learned) return give_up(learned.error());
    auto recorder = start_recording(tracker, options);  // outlives the runner
    if (!recorder) return give_up(recorder.error());
    SourceRunner runner(tracker);
    const auto following = follow_zones(options.watch, runner);
    if (*recorder) runner.record_to(**recorder);
    std::vector<Fix> kept;  // to be smoothed
    std::size_t given = 0;
    tracker.on_fixes([&](const FixBatch& batch) {
        given += batch.given.size();
        if (options.smooth) kept.insert(kept.end(), batch.given.begin(), batch.given.end());
    });
    if (options.smooth) tracker.keep_history();

    const Overflow overflow = options.run.on_time ? Overflow::drop_oldest : Overflow::wait;
    auto file = open_fix_file(site, options);
    if (!file) return give_up(file.error());
    if (*file && !options.smooth) runner.add_sink(std::move(*file), overflow);
    if (options.outputs) {
        if (auto opened = open_outputs(runner, tracker, overflow); !opened) return give_up(opened.error());
    }
    if (options.page) {
        if (auto opened = open_page(runner, tracker, options); !opened) return give_up(opened.error());
    }

    if (auto ran = runner.run(options.run, options.stop ? *options.stop : stop_requested(), progress_bar("running")); !ran) return give_up(ran.error());
    Result<void> written = runner.finish_sinks();
    if (const auto recorded = finish_recording(options.record.folder, recorder->get()); written) written = recorded;
    if (options.smooth) {
        kept = smoothed(tracker, kept, *options.smooth);
        given = kept.size();
        if (*file) written = (*file)->give({0, kept, {}});
    }
    say_what_happened(tracker, runner, given);
    if (written) return done;
    log_error(written.error().message);
    return failed;
}

}  // namespace roomfix
