#include "roomfix/evaluate/truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/base/csv.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/base/text_file.hpp"
#include "roomfix/base/text_lines.hpp"
#include "roomfix/observation/tum_line.hpp"

namespace roomfix {
namespace {

constexpr std::size_t place_columns = 4;  // time,robot,x,y

/// Does the first line name the columns, and yaw among them? Nothing where it names others.
std::optional<bool> has_yaw(const std::vector<std::string_view>& names) {
    constexpr std::string_view wanted[] = {"time", "robot", "x", "y"};
    if (names.size() < place_columns || !std::equal(std::begin(wanted), std::end(wanted), names.begin())) return std::nullopt;
    if (names.size() == place_columns) return false;
    if (names[place_columns] != "yaw") return std::nullopt;
    return true;
}

/// Nothing where the line is no pose. A line that ends before its yaw was cut off.
std::optional<StampedPose> pose_of(const std::vector<std::string_view>& fields, bool with_yaw) {
    if (with_yaw ? fields.size() <= place_columns : fields.size() != place_columns) return std::nullopt;
    const auto time = parse_seconds(fields[0]);
    const auto x = parse_number(fields[2]), y = parse_number(fields[3]);
    if (!time || !x || !y) return std::nullopt;
    StampedPose pose{*time, {*x, *y, 0}, false};
    if (!with_yaw || fields[place_columns].empty()) return pose;
    const auto yaw = parse_number(fields[place_columns]);
    if (!yaw) return std::nullopt;
    pose.pose.yaw = *yaw;
    pose.yaw_known = true;
    return pose;
}

Truth those_with(const Truth& truth, bool unknown) {
    Truth some;
    for (const auto& [name, poses] : truth) {
        if (names_unknown_thing(name) == unknown) some.emplace(name, poses);
    }
    return some;
}

/// Several things under one name would be one that jumps to and fro: says where, or nothing.
std::string twice_at_once(const Truth& truth) {
    for (const auto& [name, poses] : truth) {
        if (!names_unknown_thing(name)) continue;
        const auto same = std::adjacent_find(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) { return a.time == b.time; });
        if (same == poses.end()) continue;
        return fmt::format("'{}' is at two places at {} s: number such things, unknown-1, unknown-2, ...", name, seconds_text(same->time));
    }
    return {};
}

/// Between two moments, how far from the first to the second: 0..1.
double part_between(const StampedPose& before, const StampedPose& after, Nanoseconds time) {
    return after.time == before.time ? 0 : to_seconds(time - before.time) / to_seconds(after.time - before.time);
}

/// The yaw at a time from the last known one before `next` and the first one from it on.
std::optional<double> yaw_at(const std::vector<StampedPose>& poses, std::vector<StampedPose>::const_iterator next, Nanoseconds time, double gap) {
    auto after = next;
    while (after != poses.end() && !after->yaw_known && to_seconds(after->time - time) <= gap) ++after;
    if (after == poses.end() || !after->yaw_known) return std::nullopt;
    if (after->time == time) return after->pose.yaw;
    auto before = next;
    while (before != poses.begin() && to_seconds(time - (before - 1)->time) <= gap) {
        --before;
        if (!before->yaw_known) continue;
        if (to_seconds(after->time - before->time) > gap) return std::nullopt;
        return wrap_angle(before->pose.yaw + part_between(*before, *after, time) * wrap_angle(after->pose.yaw - before->pose.yaw));
    }
    return std::nullopt;
}

}  // namespace

bool names_unknown_thing(std::string_view name) { return name == "unknown" || name.substr(0, 8) == "unknown-"; }

Truth robots_of(const Truth& truth) { return those_with(truth, false); }

Truth unknown_things_of(const Truth& truth) { return those_with(truth, true); }

Result<Truth> parse_truth(std::string_view text) {
    Truth truth;
    std::string failure;
    std::optional<bool> with_yaw;
    each_line(text, [&](std::string_view line, long number) {
        if (!failure.empty()) return;
        const auto fields = csv_fields(line);
        if (!with_yaw) {
            with_yaw = has_yaw(fields);
            if (!with_yaw) failure = "the first line must be time,robot,x,y,yaw or, where no yaw is known, time,robot,x,y";
            return;
        }
        const auto pose = pose_of(fields, *with_yaw);
        if (pose) {
            truth[std::string(fields[1])].push_back(*pose);
        } else {
            failure = fmt::format("line {}: '{}' is not time,robot,x,y{}", number, line, *with_yaw ? ",yaw; a yaw that is not known is left empty" : "");
        }
    });
    if (failure.empty() && truth.empty()) failure = "it holds no poses";
    if (!failure.empty()) return Error{failure};
    for (auto& [robot, poses] : truth) {
        std::stable_sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
    }
    if (failure = twice_at_once(truth); !failure.empty()) return Error{failure};
    return truth;
}

Result<Truth> load_truth(const std::string& file) {
    const auto text = read_text(file);
    if (!text) return Error{file + ": cannot be opened: check the name and the permissions"};
    auto truth = parse_truth(*text);
    if (!truth) return Error{file + ": " + truth.error().message};
    return truth;
}

std::optional<TruePose> pose_at(const std::vector<StampedPose>& poses, Nanoseconds time, double gap) {
    const auto next = std::lower_bound(poses.begin(), poses.end(), time, [](const StampedPose& p, Nanoseconds t) { return p.time < t; });
    if (next == poses.end()) return std::nullopt;
    TruePose pose{next->pose};
    if (next->time != time) {
        if (next == poses.begin()) return std::nullopt;
        const StampedPose& before = *(next - 1);
        if (to_seconds(next->time - before.time) > gap) return std::nullopt;
        const double part = part_between(before, *next, time);
        pose.x = before.pose.x + part * (next->pose.x - before.pose.x);
        pose.y = before.pose.y + part * (next->pose.y - before.pose.y);
    }
    const auto yaw = yaw_at(poses, next, time, gap);
    pose.yaw_known = yaw.has_value();
    pose.yaw = yaw.value_or(0);
    return pose;
}

std::string tum_text(const std::vector<StampedPose>& poses) {
    std::string text;
    for (const StampedPose& p : poses) text += tum_line(p.time, p.pose, p.yaw_known);
    return text;
}

}  // namespace roomfix
