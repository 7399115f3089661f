#include "roomfix/smooth/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

constexpr Nanoseconds longest_gap = 200'000'000;  // ns between fixes that are joined by a straight line

}  // namespace

KnotWeights knot_weights(double part, double seconds) {
    const double s = part, s2 = s * s, s3 = s2 * s;
    KnotWeights w;
    w.row(0) << 1 - 3 * s2 + 2 * s3, seconds * (s - 2 * s2 + s3), 3 * s2 - 2 * s3, seconds * (s3 - s2);
    w.row(1) << (6 * s2 - 6 * s) / seconds, 1 - 4 * s + 3 * s2, (6 * s - 6 * s2) / seconds, 3 * s2 - 2 * s;
    return w;
}

Knot between(const Knot& before, const Knot& after, const KnotWeights& weights) {
    Knot knot;
    for (int row = 0; row < 2; ++row) {
        knot.segment<3>(3 * row) =
            weights(row, 0) * before.head<3>() + weights(row, 1) * before.tail<3>() + weights(row, 2) * after.head<3>() + weights(row, 3) * after.tail<3>();
    }
    return knot;
}

std::size_t Trajectory::knot_before(Nanoseconds time) const {
    const auto after = std::upper_bound(times.begin(), times.end(), time);
    return std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - times.begin() - 1, 0)), knots.size() - 2);
}

double Trajectory::part_in(std::size_t knot, Nanoseconds time) const { return to_seconds(time - times[knot]) / seconds_after(knot); }

KnotWeights Trajectory::weights_in(std::size_t knot, Nanoseconds time) const { return knot_weights(part_in(knot, time), seconds_after(knot)); }

Knot Trajectory::at(Nanoseconds time) const {
    const std::size_t k = knot_before(time);
    return between(knots[k], knots[k + 1], weights_in(k, time));
}

Trajectory Trajectory::part(Nanoseconds from, Nanoseconds to) const {
    const auto first = static_cast<std::ptrdiff_t>(knot_before(std::max(from, start())));
    const auto last = std::max<std::ptrdiff_t>(std::lower_bound(times.begin(), times.end() - 1, to) - times.begin(), first + 1);
    return {{times.begin() + first, times.begin() + last + 1}, {knots.begin() + first, knots.begin() + last + 1}};
}

std::vector<Nanoseconds> knot_times(std::vector<Nanoseconds> measured, Nanoseconds step, Nanoseconds closest) {
    std::sort(measured.begin(), measured.end());
    std::vector<Nanoseconds> times;
    for (const Nanoseconds time : measured) {
        if (!times.empty() && time - times.back() < closest) continue;
        const Nanoseconds gap = times.empty() ? 0 : time - times.back();
        const Nanoseconds pieces = (gap + step - 1) / step;
        const Nanoseconds before = times.empty() ? 0 : times.back();
        for (Nanoseconds i = 1; i < pieces; ++i) times.push_back(before + gap * i / pieces);
        times.push_back(time);
    }
    // The very end counts, even if it is close.
    if (!times.empty() && measured.back() > times.back()) times.push_back(measured.back());
    return times;
}

namespace {

/// The knot from which `step` leads to `after`.
Knot back_by(const OdometryStep& step, const Knot& after) {
    Knot before = after;
    before[2] = after[2] - step.turned;
    before.head<2>() = after.head<2>() - Eigen::Rotation2Dd(before[2]) * step.way;
    return before;
}

void set_rates(Trajectory& trajectory) {
    auto& knots = trajectory.knots;
    for (std::size_t k = 0; k < knots.size(); ++k) {
        const std::size_t before = k == 0 ? 0 : k - 1;
        const std::size_t after = std::min(k + 1, knots.size() - 1);
        const double seconds = to_seconds(trajectory.times[after] - trajectory.times[before]);
        knots[k].tail<3>() = (knots[after].head<3>() - knots[before].head<3>()) / seconds;
    }
}

}  // namespace

std::optional<Trajectory> first_trajectory(const std::vector<Fix>& fixes, const std::vector<Nanoseconds>& times, const OdometryTrack& driven, int like_turns) {
    std::vector<const Fix*> known;
    for (const Fix& fix : fixes) {
        if (fix.status != FixStatus::none && (known.empty() || fix.time > known.back()->time)) known.push_back(&fix);
    }
    if (known.size() < 2 || times.size() < 2) return std::nullopt;
    Trajectory trajectory{times, std::vector<Knot>(times.size(), Knot::Zero())};
    const double turn = 2 * std::numbers::pi / std::max(like_turns, 1);
    // From the end backwards: later the tracker knew more.
    std::size_t after = known.size() - 1;  // the first known fix not before the knot, where there is one
    for (std::size_t k = trajectory.knots.size(); k-- > 0;) {
        const Nanoseconds time = times[k];
        while (after > 0 && known[after - 1]->time >= time) --after;
        const Fix& b = *known[after];
        const Fix& a = after > 0 && b.time >= time ? *known[after - 1] : b;
        Knot& knot = trajectory.knots[k];
        const bool last = k + 1 == trajectory.knots.size();
        const bool gap = time < a.time || time > b.time || b.time - a.time > longest_gap;
        const auto wheels = last ? std::nullopt : driven.step(time, times[k + 1]);
        if (gap && wheels) {
            knot = back_by(*wheels, trajectory.knots[k + 1]);
            continue;
        }
        const double part = b.time > a.time ? std::clamp(to_seconds(time - a.time) / to_seconds(b.time - a.time), 0.0, 1.0) : 0;
        const double expected = last ? b.pose.yaw : trajectory.knots[k + 1][2] - (wheels ? wheels->turned : 0);
        const double yaw_b = b.yaw_known ? nearest_angle(b.pose.yaw, expected, last ? 2 * std::numbers::pi : turn) : expected;
        const double yaw_a = a.yaw_known ? nearest_angle(a.pose.yaw, yaw_b, turn) : yaw_b;
        knot.head<3>() << a.pose.x + part * (b.pose.x - a.pose.x), a.pose.y + part * (b.pose.y - a.pose.y), yaw_a + part * (yaw_b - yaw_a);
    }
    set_rates(trajectory);
    return trajectory;
}

}  // namespace roomfix
