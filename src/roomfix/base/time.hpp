// Time is nanoseconds since the epoch.
#pragma once

#include <chrono>
#include <cstdint>

namespace roomfix {

using Nanoseconds = std::int64_t;

constexpr double to_seconds(Nanoseconds t) { return static_cast<double>(t) * 1e-9; }
constexpr Nanoseconds from_seconds(double s) { return static_cast<Nanoseconds>(s * 1e9 + (s < 0 ? -0.5 : 0.5)); }

/// The system's clock, which may be set anew at any time.
inline Nanoseconds system_now() { return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count(); }

}  // namespace roomfix
