// The sub-commands. Each adds itself to the command line.
#pragma once

#include "command_line.hpp"

namespace roomfix {

void add_demo(Command& program);
void add_run(Command& program);
void add_replay(Command& program);
void add_evaluate(Command& program);
void add_export(Command& program);
void add_fix(Command& program);
void add_simulate(Command& program);
void add_reproduce(Command& program);
void add_calibrate(Command& program);
void add_check(Command& program);
void add_cameras(Command& program);
void add_doctor(Command& program);
void add_init(Command& program);

}  // namespace roomfix
