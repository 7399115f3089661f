// Where everything in a scenario really is, as the rows of truth.csv.
#pragma once

#include <string>

#include "roomfix/base/time.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {

/// The first line of truth.csv, with its end.
inline constexpr const char* truth_header = "time,robot,x,y,yaw\n";

/// One row (x, y: m, yaw: rad, map frame) for every robot, and `unknown-N` for every other thing, that is there `time` s after the scenario's begin.
/// `stamp`: the time written, ns.
std::string truth_rows(const Scenario& scenario, double time, Nanoseconds stamp);

}  // namespace roomfix
