#include "commands.hpp"
#include "roomfix/version.hpp"

int main(int argc, char** argv) {
    const std::string version = std::string("roomfix ") + roomfix::version;
    return roomfix::run_command_line(argc, argv, "roomfix finds robots indoors with ordinary cameras.", version, [](roomfix::Command& program) {
        program.require_command();
        program.footer("Start with: roomfix demo");
        roomfix::add_demo(program);
        roomfix::add_run(program);
        roomfix::add_replay(program);
        roomfix::add_evaluate(program);
        roomfix::add_export(program);
        roomfix::add_fix(program);
        roomfix::add_simulate(program);
        roomfix::add_reproduce(program);
        roomfix::add_calibrate(program);
        roomfix::add_check(program);
        roomfix::add_cameras(program);
        roomfix::add_doctor(program);
        roomfix::add_init(program);
    });
}
