// What was recorded: fixes, from a file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix {

/// Fixes of a JSON-lines file, as roomfix writes them. Bad lines cost themselves only and are in `problems`.
struct RecordedFixes {
    std::vector<Fix> fixes;           // in the order of their times
    std::vector<Fix> unknown_things;  // of people and other things that are no robots, likewise; `robot` is the thing's id
    std::vector<std::string> problems;
};
RecordedFixes parse_fixes(std::string_view text);
Result<RecordedFixes> load_fixes(const std::string& file);

}  // namespace roomfix
