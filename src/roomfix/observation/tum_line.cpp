#include "roomfix/observation/tum_line.hpp"

#include <fmt/format.h>

#include <cmath>

#include "roomfix/base/number.hpp"

namespace roomfix {

std::string tum_line(Nanoseconds time, const Pose2& pose, bool yaw_known) {
    const double half = yaw_known ? 0.5 * pose.yaw : 0;
    return fmt::format("{} {} {} 0 0 0 {} {}\n", seconds_text(time), number_text(pose.x), number_text(pose.y), number_text(std::sin(half)),
                       number_text(std::cos(half)));
}

}  // namespace roomfix
