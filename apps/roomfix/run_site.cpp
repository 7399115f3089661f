#include "run_site.hpp"

#include <fmt/format.h>

#include "commands.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/pipeline/site_runner.hpp"
#include "several_values.hpp"
#include "terminal.hpp"

namespace roomfix {

void add_recording_options(CLI::App& command, std::vector<std::string>& background, int& threads) {
    threads = hardware_threads();
    add_repeatable(command, "--background", background, "picture, folder or video to learn the background from, for all cameras");
    command.add_option("--threads", threads, "that look at frames side by side; the result is the same with any number")
        ->capture_default_str()
        ->check(CLI::Range(1, 256));
}

Result<void> learn_backgrounds(SiteRunner& runner, const Site& site, const std::vector<std::string>& for_all) {
    for (std::size_t i = 0; i < runner.cameras(); ++i) {
        const SiteCamera& camera = runner.camera(i);
        if (!runner.is_fixed(i)) continue;
        std::vector<std::string> sources = for_all;
        if (sources.empty() && !camera.background.empty()) sources = {resolved_path(site, camera.background)};
        if (sources.empty()) {
            say(fmt::format("camera {}: no background given; learning it while running", camera.id));
            continue;
        }
        auto background = learn_background(camera, sources, progress_bar("learning the background of " + camera.id));
        if (!background) return background.error();
        runner.set_background(i, std::move(background->grey), std::move(background->colour));
    }
    return {};
}

int run_site(const Site& site, const RunOptions& options) {
    auto runner = SiteRunner::create(site);
    if (!runner) {
        complain(runner.error().message);
        return bad_input;
    }
    SiteRunner& room = **runner;
    const auto give_up = [](const Error& error) {
        complain(error.message);
        return bad_input;
    };
    if (auto learned = learn_backgrounds(room, site, options.background); !learned) return give_up(learned.error());
    if (options.smooth) room.keep_for_smoothing();
    std::string fixes = options.fixes;
    if (fixes.empty() && !site.outputs.jsonl.empty()) fixes = resolved_path(site, site.outputs.jsonl);
    if (!fixes.empty()) {
        if (auto opened = room.write_fixes_to(fixes); !opened) return give_up(opened.error());
    }
    if (options.page) {
        WebOutput web = site.outputs.web.value_or(WebOutput{});
        if (!options.host.empty()) web.host = options.host;
        if (options.port >= 0) web.port = options.port;
        if (auto served = room.serve_page(web.host, web.port); !served) return give_up(served.error());
        say(fmt::format("the map is at http://{}:{}", web.host, room.page_port()));
    }
    if (auto ran = room.run_sources(options.run, stop_requested(), progress_bar("running")); !ran) return give_up(ran.error());
    if (options.smooth) {
        for (const Unsettled& part : room.write_smoothed(*options.smooth, progress_bar("smoothing"))) {
            say(fmt::format("{}: smoothing did not settle between {:.1f} s and {:.1f} s: the fixes of that time are the tracker's", part.robot,
                            to_seconds(part.from), to_seconds(part.to)));
        }
    }
    for (const SourceState& state : room.source_states()) {
        const std::string dropped = state.dropped > 0 ? fmt::format(", {} not looked at since this machine is too slow", state.dropped) : "";
        say(fmt::format("camera {}: {} frames, {:.2f} ms each, {} bad{}; {}", state.id, state.frames, 1e3 * state.busy, state.bad_frames, dropped,
                        state.message));
    }
    if (room.stage_times().summary(Stage::moment).count > 0) say(room.stage_times().text());
    for (const std::string& problem : room.line_problems()) say("not used: " + problem);
    for (const std::string& suspicion : room.suspicious_inputs()) say("look at this: " + suspicion);
    const TrackerCounts counts = room.tracker_counts();
    if (counts.late > 0) say(fmt::format("{} observations came more than a second late and were not used", counts.late));
    if (counts.impossible > 0) say(fmt::format("{} observations had impossible values and were not used", counts.impossible));
    if (counts.strayed > 0) say(fmt::format("{} observations had times far from all others and were not used", counts.strayed));
    say(fmt::format("{} fixes given", room.fixes_given()));
    for (const std::string& reason : room.robots_not_found()) say("without a fix at the end: " + reason);
    return done;
}

}  // namespace roomfix
