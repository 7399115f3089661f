// The sub-commands. Each adds itself to the command line and stores its exit code when it runs.
#pragma once

#include <CLI/CLI.hpp>

namespace roomfix {

constexpr int done = 0;
constexpr int failed = 1;
constexpr int bad_input = 2;

void add_demo(CLI::App& app, int& exit_code);
void add_run(CLI::App& app, int& exit_code);
void add_replay(CLI::App& app, int& exit_code);
void add_evaluate(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);
void add_fix(CLI::App& app, int& exit_code);
void add_simulate(CLI::App& app, int& exit_code);
void add_reproduce(CLI::App& app, int& exit_code);
void add_calibrate(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_cameras(CLI::App& app, int& exit_code);
void add_doctor(CLI::App& app, int& exit_code);
void add_init(CLI::App& app, int& exit_code);

}  // namespace roomfix
