#include "commands.hpp"
#include "roomfix/version.hpp"

int main(int argc, char** argv) {
    CLI::App app{"roomfix finds robots indoors with ordinary cameras."};
    app.set_version_flag("--version", std::string("roomfix ") + roomfix::version);
    app.require_subcommand(1);
    app.footer("Start with: roomfix demo");
    int exit_code = roomfix::done;
    roomfix::add_demo(app, exit_code);
    roomfix::add_run(app, exit_code);
    roomfix::add_replay(app, exit_code);
    roomfix::add_evaluate(app, exit_code);
    roomfix::add_export(app, exit_code);
    roomfix::add_fix(app, exit_code);
    roomfix::add_simulate(app, exit_code);
    roomfix::add_reproduce(app, exit_code);
    roomfix::add_calibrate(app, exit_code);
    roomfix::add_check(app, exit_code);
    roomfix::add_cameras(app, exit_code);
    roomfix::add_doctor(app, exit_code);
    roomfix::add_init(app, exit_code);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& problem) {
        return app.exit(problem) == 0 ? roomfix::done : roomfix::bad_input;
    }
    return exit_code;
}
