#include "roomfix/pipeline/odometry_poses.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {

std::optional<Pose2> odometry_at(std::span<const OdometryObservation> reports, Nanoseconds time) {
    constexpr double longest_gap = 1;  // s
    constexpr double fastest = 15;     // m/s: a faster jump is a restarted odometry
    const auto after = std::lower_bound(reports.begin(), reports.end(), time, [](const OdometryObservation& o, Nanoseconds t) { return o.time < t; });
    if (after == reports.end()) return std::nullopt;
    if (after->time == time) return after->pose;
    if (after == reports.begin()) return std::nullopt;
    const OdometryObservation& before = *(after - 1);
    const double gap = to_seconds(after->time - before.time);
    const Pose2 a = before.pose, b = after->pose;
    if (gap > longest_gap || std::hypot(b.x - a.x, b.y - a.y) > fastest * gap) return std::nullopt;
    const double part = to_seconds(time - before.time) / gap;
    return Pose2{a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), wrap_angle(a.yaw + part * wrap_angle(b.yaw - a.yaw))};
}

}  // namespace roomfix
