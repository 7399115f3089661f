#include "roomfix/connect/sense_lines.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "roomfix/base/number.hpp"

namespace roomfix {
namespace {

constexpr std::size_t longest_line = 4096;
constexpr std::size_t most_problems = 20;  // that are told of one message

/// Robots that have a source for one of their senses: the only one, or -1.
class OnlyOne {
public:
    void add(int robot) {
        robot_ = count_ == 0 || robot == robot_ ? robot : -1;
        ++count_;
    }
    int robot() const { return robot_; }

private:
    int robot_ = -1, count_ = 0;
};

int only_ranging(const Site& site, const std::string& source, int& receiver) {
    OnlyOne found;
    for (std::size_t r = 0; r < site.robots.size(); ++r) {
        for (std::size_t k = 0; k < site.robots[r].receivers.size(); ++k) {
            if (site.robots[r].receivers[k].source != source) continue;
            found.add(static_cast<int>(r));
            receiver = static_cast<int>(k);
        }
    }
    return found.robot();
}

template <class Observation>
void set_times(std::vector<Observation>& observations, std::map<int, SenderClock>& clocks, Nanoseconds arrival, double steady) {
    for (Observation& observation : observations) {
        if (observation.time != arrival) observation.time = clocks[observation.robot].ours(observation.time, arrival, steady);
    }
}

}  // namespace

SenseLines::SenseLines(const Site& site, const std::string& source)
    : site_(site), ranging_(only_ranging(site, source, receiver_)), ranges_(site, ranging_, receiver_) {
    OnlyOne driving, detecting;
    for (std::size_t r = 0; r < site.robots.size(); ++r) {
        const SiteRobot& robot = site.robots[r];
        if (robot.odometry && robot.odometry->source == source) driving.add(static_cast<int>(r));
        if (robot.detector && robot.detector->source == source) detecting.add(static_cast<int>(r));
    }
    driving_ = driving.robot();
    detecting_ = detecting.robot();
}

void SenseLines::read_line(std::string_view line, Nanoseconds arrival, Readings& readings) {
    auto json = nlohmann::json::parse(line, nullptr, false);
    if (!json.is_object()) {
        readings.ranges.problems.push_back("a line is no JSON object");
        return;
    }
    if (!json.contains("time")) json["time"] = seconds_text(arrival);
    const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
    if (json.contains("x") || json.contains("yaw")) {
        auto batch = parse_odometry(text, site_, driving_);
        if (!batch) readings.odometry.problems.push_back(batch.error().message);
        if (!batch) return;
        readings.odometry.poses.insert(readings.odometry.poses.end(), batch->poses.begin(), batch->poses.end());
        for (std::string& problem : batch->problems) readings.odometry.problems.push_back(std::move(problem));
    } else if (json.contains("landmark") || json.contains("bearing")) {
        auto batch = parse_sightings(text, site_, detecting_);
        if (!batch) readings.sightings.problems.push_back(batch.error().message);
        if (!batch) return;
        readings.sightings.sightings.insert(readings.sightings.sightings.end(), batch->sightings.begin(), batch->sightings.end());
        for (std::string& problem : batch->problems) readings.sightings.problems.push_back(std::move(problem));
    } else {
        ranges_.feed(text, arrival, readings.ranges);
    }
}

Readings SenseLines::read(std::string_view lines, Nanoseconds arrival, double steady) {
    Readings readings;
    while (!lines.empty()) {
        const std::size_t end = lines.find('\n');
        const std::string_view line = lines.substr(0, end);
        lines.remove_prefix(end == std::string_view::npos ? lines.size() : end + 1);
        if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
        if (line.size() > longest_line) {
            readings.ranges.problems.push_back(fmt::format("a line of {} bytes is too long to be a reading", line.size()));
        } else {
            read_line(line, arrival, readings);
        }
        for (std::vector<std::string>* problems : {&readings.ranges.problems, &readings.odometry.problems, &readings.sightings.problems}) {
            if (problems->size() > most_problems) problems->resize(most_problems);
        }
    }
    set_times(readings.ranges.ranges, clocks_, arrival, steady);
    set_times(readings.ranges.differences, clocks_, arrival, steady);
    set_times(readings.odometry.poses, clocks_, arrival, steady);
    set_times(readings.sightings.sightings, clocks_, arrival, steady);
    return readings;
}

std::vector<std::string> SenseLines::clocks() const {
    std::vector<std::string> told;
    for (const auto& [robot, clock] : clocks_) told.push_back(site_.robots[static_cast<std::size_t>(robot)].id + ": " + clock.told());
    return told;
}

}  // namespace roomfix
