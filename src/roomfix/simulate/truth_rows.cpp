#include "roomfix/simulate/truth_rows.hpp"

#include <fmt/format.h>

#include "roomfix/base/number.hpp"

namespace roomfix {
namespace {

std::string truth_row(Nanoseconds stamp, const std::string& name, const Pose2& pose) {
    return fmt::format("{},{},{},{},{}\n", seconds_text(stamp), name, number_text(pose.x), number_text(pose.y), number_text(pose.yaw));
}

}  // namespace

std::string truth_rows(const Scenario& scenario, double time, Nanoseconds stamp) {
    std::string rows;
    for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
        if (time < scenario.robots[r].until) rows += truth_row(stamp, scenario.robots[r].robot.id, true_pose(scenario, r, time));
    }
    for (std::size_t thing = 0; thing < scenario.others.size(); ++thing) {
        const ScenarioRobot& other = scenario.others[thing];
        if (time < other.until) rows += truth_row(stamp, fmt::format("unknown-{}", thing + 1), robot_pose(other, time));
    }
    return rows;
}

}  // namespace roomfix
