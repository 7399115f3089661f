// What is reported of all robots together and of what is no robot, in words.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "roomfix/evaluate/error_report.hpp"

namespace roomfix {

/// GOSPA, IDF1 and HOTA by name, with their parts; nothing where the truth knows no robot.
std::vector<std::pair<std::string, std::string>> several_targets_figures(const ErrorReport& report);

/// What these figures are of.
std::string several_targets_heading(const ErrorReport& report);

/// How often a fix is wrong and sure of itself, and how unknown things were found: one sentence each.
std::vector<std::string> wrong_and_unknown(const ErrorReport& report);

}  // namespace roomfix
