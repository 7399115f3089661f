#include <fmt/format.h>

#include <memory>
#include <optional>

#include "commands.hpp"
#include "roomfix/simulate/write_session.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string scenario;
    std::string folder;
    SessionOptions session;
    double readout = 0;  // s
    std::optional<double> speed;
    HallSettings hall;
};

int simulate(const Arguments& arguments) {
    const HallSettings usual;
    if (arguments.scenario != "hall" && (arguments.hall.robots != usual.robots || arguments.hall.cameras != usual.cameras)) {
        complain(fmt::format("--robots and --cameras are of the scenario hall: leave them out for {}", arguments.scenario));
        return bad_input;
    }
    auto scenario = make_scenario(arguments.scenario, arguments.session.seed, arguments.hall);
    if (!scenario) {
        complain(scenario.error().message);
        return bad_input;
    }
    if (arguments.readout > 0) roll_shutters(*scenario, arguments.readout);
    if (arguments.speed) drive_at(*scenario, *arguments.speed);
    const auto written = write_session(*scenario, arguments.folder, arguments.session, progress_bar("rendering " + arguments.scenario));
    if (!written) {
        complain(written.error().message);
        return bad_input;
    }
    say(fmt::format("{}: session written; try: roomfix run {}/site.yaml", arguments.folder, arguments.folder));
    return done;
}

}  // namespace

void add_simulate(Command& program) {
    Command command = program.add_command("simulate", "renders a session with exact truth");
    auto arguments = std::make_shared<Arguments>();
    command.option("SCENARIO", arguments->scenario, fmt::format("one of {}", fmt::join(scenario_names(), ", "))).required();
    command.option("-o,--output", arguments->folder, "session folder to write").required();
    command.option("--duration", arguments->session.duration, "seconds (default: the scenario's)").range(0.05, 36000.0);
    command.option("--seed", arguments->session.seed, "noise, clicks, sizes; of the hall all that is in it").show_default();
    command.option("--readout", arguments->readout, "seconds from the first row's exposure to the last row's: a rolling shutter").range(0.0, 0.2);
    command.option("--speed", arguments->speed, "of all robots, m/s (default: the scenario's)").range(0.0, 5.0);
    command.option("--robots", arguments->hall.robots, "of the scenario hall").range(1, 60).show_default();
    command.option("--cameras", arguments->hall.cameras, "of the scenario hall").range(1, 32).show_default();
    command.flag("--png", arguments->session.png, "lossless frames instead of JPEG");
    command.footer("Example: roomfix simulate li2014 -o /tmp/li2014 --duration 10");
    command.on_run([=] { return simulate(*arguments); });
}

}  // namespace roomfix
