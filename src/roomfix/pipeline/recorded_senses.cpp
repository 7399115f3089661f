#include "roomfix/pipeline/recorded_senses.hpp"

#include <algorithm>
#include <limits>

#include "roomfix/connect/range_source.hpp"

namespace roomfix {
namespace {

template <class T>
void append(std::vector<T>& all, const std::vector<T>& more) {
    all.insert(all.end(), more.begin(), more.end());
}

template <class T>
void sort_by_time(std::vector<T>& all) {
    std::stable_sort(all.begin(), all.end(), [](const T& a, const T& b) { return a.time < b.time; });
}

}  // namespace

Result<RecordedSenses> RecordedSenses::load(const Site& site) {
    RecordedSenses senses;
    std::vector<std::string> read;
    const auto is_new = [&](const std::string& file) {
        if (file.empty() || std::find(read.begin(), read.end(), file) != read.end()) return false;
        read.push_back(file);
        return true;
    };
    for (std::size_t r = 0; r < site.robots.size(); ++r) {
        const SiteRobot& robot = site.robots[r];
        if (robot.receiver && !is_live_range_source(robot.receiver->source) && is_new(robot.receiver->source)) {
            const auto batch = load_ranges(resolved_path(site, robot.receiver->source), site, static_cast<int>(r));
            if (!batch) return batch.error();
            append(senses.ranges_.ranges, batch->ranges);
            append(senses.ranges_.differences, batch->differences);
            append(senses.problems_, batch->problems);
        }
        if (robot.odometry && is_new(robot.odometry->source)) {
            const auto batch = load_odometry(resolved_path(site, robot.odometry->source), site, static_cast<int>(r));
            if (!batch) return batch.error();
            append(senses.odometry_.poses, batch->poses);
            append(senses.problems_, batch->problems);
        }
    }
    sort_by_time(senses.ranges_.ranges);
    sort_by_time(senses.ranges_.differences);
    sort_by_time(senses.odometry_.poses);
    return senses;
}

void RecordedSenses::tell_until(Nanoseconds time, const std::function<void(const RangeBatch&)>& hear, const std::function<void(const OdometryBatch&)>& drive) {
    const auto& ranges = ranges_.ranges;
    const auto& poses = odometry_.poses;
    constexpr Nanoseconds ended = std::numeric_limits<Nanoseconds>::max();
    while (true) {
        const Nanoseconds range_time = next_range_ < ranges.size() ? ranges[next_range_].time : ended;
        const Nanoseconds pose_time = next_odometry_ < poses.size() ? poses[next_odometry_].time : ended;
        const Nanoseconds next = std::min(range_time, pose_time);
        if (next > time || next == ended) break;
        if (pose_time <= range_time) {
            drive({{poses[next_odometry_++]}, {}});
        } else {
            RangeBatch one;
            one.ranges.push_back(ranges[next_range_++]);
            hear(one);
        }
    }
    RangeBatch now;
    const auto& differences = ranges_.differences;
    while (next_difference_ < differences.size() && differences[next_difference_].time <= time) now.differences.push_back(differences[next_difference_++]);
    if (!now.differences.empty()) hear(now);
}

}  // namespace roomfix
