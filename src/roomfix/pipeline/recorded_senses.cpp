#include "roomfix/pipeline/recorded_senses.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "roomfix/connect/range_source.hpp"
#include "roomfix/pipeline/live_senses.hpp"

namespace roomfix {
namespace {

template <class T>
void append(std::vector<T>& all, const std::vector<T>& more) {
    all.insert(all.end(), more.begin(), more.end());
}

constexpr Nanoseconds ended = std::numeric_limits<Nanoseconds>::max();

template <class T>
Nanoseconds time_of_next(const std::vector<T>& all, std::size_t next) {
    return next < all.size() ? all[next].time : ended;
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
        if (file.empty() || is_live_sense(file) || std::find(read.begin(), read.end(), file) != read.end()) return false;
        read.push_back(file);
        return true;
    };
    for (std::size_t r = 0; r < site.robots.size(); ++r) {
        const SiteRobot& robot = site.robots[r];
        for (std::size_t k = 0; k < robot.receivers.size(); ++k) {
            const std::string& source = robot.receivers[k].source;
            if (!is_new(source)) continue;
            const auto batch = load_ranges(resolved_path(site, source), site, static_cast<int>(r), static_cast<int>(k));
            if (!batch) return batch.error();
            append(senses.ranges_.ranges, batch->ranges);
            append(senses.ranges_.differences, batch->differences);
            append(senses.problems_, batch->problems);
        }
        if (robot.detector && is_new(robot.detector->source)) {
            const auto batch = load_sightings(resolved_path(site, robot.detector->source), site, static_cast<int>(r));
            if (!batch) return batch.error();
            append(senses.sightings_.sightings, batch->sightings);
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
    sort_by_time(senses.sightings_.sightings);
    return senses;
}

Senses RecordedSenses::of(int robot) const {
    Senses own;
    const auto pick = [robot](const auto& all, auto& some) {
        std::copy_if(all.begin(), all.end(), std::back_inserter(some), [robot](const auto& o) { return o.robot == robot; });
    };
    pick(ranges_.ranges, own.ranges);
    pick(ranges_.differences, own.differences);
    pick(sightings_.sightings, own.sightings);
    pick(odometry_.poses, own.odometry);
    return own;
}

void RecordedSenses::drop_odometry(int robot, const std::string& why) {
    std::erase_if(odometry_.poses, [robot](const OdometryObservation& o) { return o.robot == robot; });
    problems_.push_back(why);
}

std::optional<Nanoseconds> RecordedSenses::next_time() const {
    const Nanoseconds next = std::min({time_of_next(odometry_.poses, next_odometry_), time_of_next(ranges_.ranges, next_range_),
                                       time_of_next(ranges_.differences, next_difference_), time_of_next(sightings_.sightings, next_sighting_)});
    if (next == ended) return std::nullopt;
    return next;
}

void RecordedSenses::tell_until(Nanoseconds time, const SenseListener& listener) {
    while (true) {
        const Nanoseconds pose = time_of_next(odometry_.poses, next_odometry_);
        const Nanoseconds range = time_of_next(ranges_.ranges, next_range_);
        const Nanoseconds difference = time_of_next(ranges_.differences, next_difference_);
        const Nanoseconds sighting = time_of_next(sightings_.sightings, next_sighting_);
        const Nanoseconds next = std::min({pose, range, difference, sighting});
        if (next > time || next == ended) break;
        listener.goes_on(next);
        if (pose == next) {
            listener.drives({{odometry_.poses[next_odometry_++]}, {}});
        } else if (range == next) {
            listener.hears({{ranges_.ranges[next_range_++]}, {}, {}});
        } else if (difference == next) {
            listener.hears({{}, {ranges_.differences[next_difference_++]}, {}});
        } else {
            listener.detects({{sightings_.sightings[next_sighting_++]}, {}});
        }
    }
}

}  // namespace roomfix
