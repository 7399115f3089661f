#include "roomfix/estimate/odometry_track.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {

std::optional<Nanoseconds> OdometryTrack::add(Nanoseconds time, const Pose2& pose) {
    const auto after = std::upper_bound(poses_.begin(), poses_.end(), time, [](Nanoseconds t, const Stamped& p) { return t < p.time; });
    if (after != poses_.begin() && (after - 1)->time == time) return std::nullopt;
    const Nanoseconds changed = after == poses_.begin() ? time : (after - 1)->time;
    poses_.insert(after, {time, pose});
    return changed;
}

bool OdometryTrack::connected(const Stamped& a, const Stamped& b) const {
    const double seconds = to_seconds(b.time - a.time);
    return seconds <= limits_.longest_gap && std::hypot(b.pose.x - a.pose.x, b.pose.y - a.pose.y) <= limits_.fastest * seconds &&
           std::abs(wrap_angle(b.pose.yaw - a.pose.yaw)) <= limits_.fastest_turn * seconds;
}

OdometryTrack::Piece OdometryTrack::piece(Nanoseconds from, Nanoseconds to) const {
    Piece piece;
    const auto next = std::upper_bound(poses_.begin(), poses_.end(), from, [](Nanoseconds t, const Stamped& p) { return t < p.time; });
    if (next == poses_.end()) {
        piece.end = to;
        return piece;
    }
    piece.end = std::min(to, next->time);
    if (next == poses_.begin() || !connected(*(next - 1), *next)) return piece;
    const Stamped& a = *(next - 1);
    const Stamped& b = *next;
    const double whole = to_seconds(b.time - a.time);
    const double turned = wrap_angle(b.pose.yaw - a.pose.yaw);
    const Eigen::Vector2d way = Eigen::Rotation2Dd(-a.pose.yaw) * Eigen::Vector2d(b.pose.x - a.pose.x, b.pose.y - a.pose.y);
    const double rate = turned / whole;
    // An arc of constant speed: the chord of a part of it points half of that part's angle from its tangent.
    const Eigen::Vector2d along = Eigen::Rotation2Dd(-0.5 * turned) * way;  // the speed in the robot's frame, times `whole`, over `shrink`
    const auto chord = [](double angle) { return std::abs(angle) < 1e-4 ? 1 - angle * angle / 24 : std::sin(0.5 * angle) / (0.5 * angle); };
    piece.driven = true;
    OdometryStep& step = piece.step;
    step.seconds = to_seconds(piece.end - from);
    step.turned = rate * step.seconds;
    step.turn_rate = rate;
    step.velocity = along / (whole * chord(turned));
    step.way = Eigen::Rotation2Dd(0.5 * step.turned) * step.velocity * step.seconds * chord(step.turned);
    return piece;
}

std::optional<OdometryStep> OdometryTrack::step(Nanoseconds from, Nanoseconds to) const {
    OdometryStep whole;
    while (from < to) {
        const Piece next = piece(from, to);
        if (!next.driven) return std::nullopt;
        whole.way += Eigen::Rotation2Dd(whole.turned) * next.step.way;
        whole.turned += next.step.turned;
        whole.seconds += next.step.seconds;
        whole.velocity = next.step.velocity;
        whole.turn_rate = next.step.turn_rate;
        from = next.end;
    }
    return whole;
}

void OdometryTrack::forget_before(Nanoseconds time) {
    const auto keep = std::upper_bound(poses_.begin(), poses_.end(), time, [](Nanoseconds t, const Stamped& p) { return t < p.time; });
    if (keep - poses_.begin() > 64) poses_.erase(poses_.begin(), keep - 1);
}

}  // namespace roomfix
