// The clock that only goes forward.
#pragma once

#include <chrono>

namespace roomfix {

/// s since some moment.
inline double steady_now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace roomfix
