// A pose as the tool evo reads it (TUM format).
#pragma once

#include <string>

#include "roomfix/base/time.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

/// "time x y z qx qy qz qw" with its line end; s, m. A yaw that is not known is written as 0.
std::string tum_line(Nanoseconds time, const Pose2& pose, bool yaw_known);

}  // namespace roomfix
