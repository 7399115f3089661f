#include <fmt/format.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "log.hpp"
#include "roomfix/base/worker_pool.hpp"
#include "roomfix/pipeline/site_watch.hpp"
#include "roomfix/site/load_site.hpp"
#include "run_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string log_level = "info";
    std::string site;
    bool no_page = false;
    RunOptions options;
};

/// Runs the site, and the new one whenever its file changes. One that cannot be used after all (an address that is taken, a secret that is not there) is
/// given up for the one before.
int run(Arguments arguments) {
    RunOptions& options = arguments.options;
    options.page = !arguments.no_page;
    options.record.site_file = arguments.site;
    std::signal(SIGPIPE, SIG_IGN);  // a peer that is gone is an error where it is written to
    auto site = load_site(arguments.site);
    if (!site) {
        log_error("the site file cannot be used:\n" + site.error().message);
        return bad_input;
    }
    const std::filesystem::path record = std::filesystem::path(options.record.folder).lexically_normal();
    std::optional<Site> before;  // that ran
    for (int round = 1;; ++round) {
        if (round > 1 && !record.empty()) {  // a session has one site
            options.record.folder = fmt::format("{}-{}", (record.has_filename() ? record : record.parent_path()).string(), round);
        }
        SiteWatch watch(arguments.site, stop_requested(),
                        [](const std::string& mistakes) { log_warning("the site file was changed, but cannot be used; the old one stays:\n" + mistakes); });
        options.watch = &watch;
        options.stop = &watch.ends();
        const int code = run_site(*site, options);
        if (auto zones = watch.zones()) site->zones = std::move(*zones);
        options.append = true;
        if (watch.changed()) {
            before = std::move(*site);
            site = watch.site();
            log_info("the site file was changed: beginning anew with it");
        } else if (code == bad_input && before) {
            log_warning("the new site cannot be run; going on with the old one");
            site = std::move(*before);
            before.reset();
        } else {
            return code;
        }
    }
}

}  // namespace

void add_run(Command& program) {
    Command command = program.add_command("run", "opens a site's sources, finds its robots, serves the page");
    auto arguments = std::make_shared<Arguments>();
    arguments->options.run.on_time = true;
    arguments->options.run.threads = hardware_threads();
    command.option("SITE", arguments->site, "site file").required();
    command.option("--fixes", arguments->options.fixes, "file for the fixes, one JSON object per line; - for stdout");
    command.repeatable("--background", arguments->options.background, "picture, folder or video to learn the background from, for all cameras");
    command.option("--speed", arguments->options.run.speed, "of recordings: 1 is real time, 0 as fast as it goes").show_default().range(0.0, 1000.0);
    command.option("--host", arguments->options.host, "address to serve the page on (default 127.0.0.1: this machine only)");
    command.option("--port", arguments->options.port, "port of the page (default 8080; 0 picks a free one)").range(0, 65535);
    command.flag("--insecure", arguments->options.insecure, "with --host: whoever reaches this machine may look, without encryption and token");
    command.flag("--no-page", arguments->no_page, "do not serve the page");
    command.option("--record", arguments->options.record.folder, "new folder for a session of all that comes, for `roomfix replay`");
    command.option("--record-minutes", arguments->options.record.limits.minutes, "keep the last of them, in parts that are whole sessions")
        .range(0.001, 1e7)
        .needs("--record");
    command.option("--record-gigabytes", arguments->options.record.limits.gigabytes, "keep no more, in parts that are whole sessions; the oldest go")
        .range(1e-6, 1e6)
        .needs("--record");
    add_log_level(command, arguments->log_level);
    command.footer("Example: roomfix run examples/hall/site.yaml --fixes fixes.jsonl");
    command.on_run([=] { return with_log(arguments->log_level, [&] { return run(*arguments); }); });
}

}  // namespace roomfix
