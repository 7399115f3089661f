#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "log.hpp"
#include "roomfix/site/load_site.hpp"
#include "run_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string log_level = "info";
    std::string session;
    RunOptions run;
    bool smooth = false;
    SmootherSettings smoother;
};

int replay(const Arguments& arguments) {
    const auto site = load_session(arguments.session);
    if (!site) {
        log_error("the session's site file cannot be used:\n" + site.error().message);
        return bad_input;
    }
    RunOptions run = arguments.run;
    if (arguments.smooth) run.smooth = arguments.smoother;
    return run_site(*site, run);
}

}  // namespace

void add_replay(Command& program) {
    Command command = program.add_command("replay", "the pipeline over a recorded session: the same input gives the same fixes, byte for byte");
    auto arguments = std::make_shared<Arguments>();
    arguments->run.run.speed = 0;
    arguments->run.fixes = "-";
    arguments->run.page = false;
    arguments->run.outputs = false;  // what is over is no news for brokers
    command.option("SESSION", arguments->session, "session folder").required();
    command.option("--fixes", arguments->run.fixes, "file for the fixes, one JSON object per line; - for stdout").show_default();
    command.option("--speed", arguments->run.run.speed, "1 is real time, 0 as fast as it goes").show_default().range(0.0, 1000.0);
    add_recording_options(command, arguments->run.background, arguments->run.run.threads);
    command.flag("--smooth", arguments->smooth, "give the best way after the fact: every fix rests on what came later, too");
    command.option("--window", arguments->smoother.window, "seconds that are smoothed at once; 0: the whole session").show_default().range(0.0, 1e6);
    command.flag("--page", arguments->run.page, "serve the page while it runs");
    add_log_level(command, arguments->log_level);
    command.footer("Example: roomfix replay session --fixes fixes.jsonl && roomfix evaluate fixes.jsonl --truth session/truth.csv");
    command.on_run([=] { return with_log(arguments->log_level, [&] { return replay(*arguments); }); });
}

}  // namespace roomfix
