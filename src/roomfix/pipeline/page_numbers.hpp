// Numbers for the page: as many digits as a screen can show.
#pragma once

#include <cmath>

namespace roomfix {

inline double rounded(double value, double unit) { return std::round(value / unit) * unit; }

}  // namespace roomfix
