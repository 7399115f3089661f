#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/pipeline/site_runner.hpp"
#include "roomfix/site/load_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string site;
    std::string fixes;
    std::string host;
    int port = -1;
    bool no_page = false;
    double speed = 1;
    std::vector<std::string> background;
};

/// A camera's background from --background, or from the site file. Without either it is learned while running.
Result<void> learn_backgrounds(SiteRunner& runner, const Site& site, const Arguments& arguments) {
    for (std::size_t i = 0; i < runner.cameras(); ++i) {
        const SiteCamera& camera = runner.camera(i);
        if (!runner.is_fixed(i)) continue;
        std::vector<std::string> sources = arguments.background;
        if (sources.empty() && !camera.background.empty()) sources = {resolved_path(site, camera.background)};
        if (sources.empty()) {
            say(fmt::format("camera {}: no background given; learning it while running", camera.id));
            continue;
        }
        auto background = learn_background(camera, sources, progress_bar("learning the background of " + camera.id));
        if (!background) return background.error();
        runner.set_background(i, std::move(*background));
    }
    return {};
}

int run(const Arguments& arguments) {
    const auto site = load_site(arguments.site);
    if (!site) {
        complain("the site file cannot be used:\n" + site.error().message);
        return bad_input;
    }
    auto runner = SiteRunner::create(*site);
    if (!runner) {
        complain(runner.error().message);
        return bad_input;
    }
    SiteRunner& room = **runner;
    const auto give_up = [](const Error& error) {
        complain(error.message);
        return bad_input;
    };
    if (auto learned = learn_backgrounds(room, *site, arguments); !learned) return give_up(learned.error());
    std::string fixes = arguments.fixes;
    if (fixes.empty() && !site->outputs.jsonl.empty()) fixes = resolved_path(*site, site->outputs.jsonl);
    if (!fixes.empty()) {
        if (auto opened = room.write_fixes_to(fixes); !opened) return give_up(opened.error());
    }
    if (!arguments.no_page) {
        WebOutput web = site->outputs.web.value_or(WebOutput{});
        if (!arguments.host.empty()) web.host = arguments.host;
        if (arguments.port >= 0) web.port = arguments.port;
        if (auto served = room.serve_page(web.host, web.port); !served) return give_up(served.error());
        say(fmt::format("the map is at http://{}:{}", web.host, room.page_port()));
    }
    if (auto ran = room.run_sources(arguments.speed, stop_requested(), progress_bar("running")); !ran) return give_up(ran.error());
    for (const SourceState& state : room.source_states()) {
        say(fmt::format("camera {}: {} frames, {:.2f} ms each, {} bad; {}", state.id, state.frames, 1e3 * state.busy, state.bad_frames, state.message));
    }
    for (const std::string& problem : room.line_problems()) say("not used: " + problem);
    const TrackerCounts counts = room.tracker_counts();
    if (counts.late > 0) say(fmt::format("{} observations came more than a second late and were not used", counts.late));
    if (counts.impossible > 0) say(fmt::format("{} observations had impossible values and were not used", counts.impossible));
    if (counts.strayed > 0) say(fmt::format("{} observations had times far from all others and were not used", counts.strayed));
    say(fmt::format("{} fixes given", room.fixes_given()));
    return done;
}

}  // namespace

void add_run(CLI::App& app, int& exit_code) {
    auto* command = app.add_subcommand("run", "opens a site's sources, finds its robots, serves the page");
    auto arguments = std::make_shared<Arguments>();
    command->add_option("SITE", arguments->site, "site file")->required();
    command->add_option("--fixes", arguments->fixes, "file for the fixes, one JSON object per line; - for stdout");
    command->add_option("--background", arguments->background, "pictures, folders or videos to learn the background from, for all cameras");
    command->add_option("--speed", arguments->speed, "of recordings: 1 is real time, 0 as fast as it goes")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1000.0));
    command->add_option("--host", arguments->host, "address to serve the page on (default 127.0.0.1: this machine only)");
    command->add_option("--port", arguments->port, "port of the page (default 8080; 0 picks a free one)")->check(CLI::Range(0, 65535));
    command->add_flag("--no-page", arguments->no_page, "do not serve the page");
    command->footer("Example: roomfix run examples/hall/site.yaml --fixes fixes.jsonl");
    command->callback([=, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace roomfix
