// Work that may crash or never end, in a process of its own.
#pragma once

#include <functional>
#include <string>

#include "roomfix/base/result.hpp"

namespace roomfix {

/// Runs `work` in a copy of this process and returns the text that it gave. For libraries that damaged input makes loop for
/// ever or crash. It may use up to `seconds` of processor time and `megabytes` of new memory, and must not rely on other threads.
/// The error says "crashed", "took more than N s" or "cannot be started: REASON". What it prints is not shown.
Result<std::string> in_own_process(const std::function<std::string()>& work, int seconds, int megabytes);

}  // namespace roomfix
