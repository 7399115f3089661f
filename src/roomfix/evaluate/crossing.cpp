#include "roomfix/evaluate/crossing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

constexpr double sure = 0.95;  // identity of a robot that is surely itself

}  // namespace

SiteRobot wheeled_robot(const std::string& id) {
    SiteRobot robot;
    robot.id = id;
    robot.shape = crossing_body;
    robot.drive = Drive::differential;
    robot.odometry = WheelOdometry{};
    return robot;
}

std::vector<SiteRobot> like_robots(bool odometry) {
    std::vector<SiteRobot> robots = {wheeled_robot("r1"), wheeled_robot("r2")};
    for (SiteRobot& robot : robots) {
        if (!odometry) robot.odometry.reset();
    }
    return robots;
}

Pose2 Passage::at(double time) const {
    constexpr double acceleration = 1.5;  // m/s^2
    const double forward = side < 0 ? 0 : std::numbers::pi;
    if (!turns_back) return {side * speed * (meet - time), lane, forward};
    // From the middle at rest: the same way out as, backwards in time, in.
    const auto way = [&](double seconds) {
        const double ramp = speed / acceleration;
        return seconds < ramp ? 0.5 * acceleration * seconds * seconds : speed * (seconds - 0.5 * ramp);
    };
    if (time < meet) return {side * way(meet - time), lane, forward};
    const double turning = std::min(time - meet, 1.0);
    return {side * way(std::max(time - meet - 1, 0.0)), lane, wrap_angle(forward + std::numbers::pi * turning)};
}

std::array<Passage, 2> random_passages(double half, Random& random) {
    const bool back = random.uniform() < 0.5;
    std::array<Passage, 2> ways;
    for (std::size_t r = 0; r < 2; ++r) ways[r] = {r == 0 ? -1.0 : 1.0, r == 0 ? -half : half, random.uniform(0.2, 0.5), 5, back};
    return ways;
}

WheelModel random_wheels(Random& random) {
    WheelModel wheels;
    wheels.scale = random.normal(0.01);
    wheels.drift = random.normal(0.01);
    return wheels;
}

std::array<WheelSimulator, 2> wheels_of(const std::array<Passage, 2>& ways, Random& random) {
    const auto wheels = [&](const Passage& way) {
        const WheelModel model = random_wheels(random);
        return WheelSimulator(
            model, [way](double t) { return way.at(t); }, random.bits());
    };
    WheelSimulator first = wheels(ways[0]);
    return {first, wheels(ways[1])};
}

void tell_wheels(Tracker& tracker, int robot, const std::vector<WheelPose>& poses) {
    for (const WheelPose& p : poses) tracker.observe({from_seconds(p.time), robot, p.pose});
}

Fix named_fix(const std::vector<Fix>& fixes, const std::string& robot) {
    const auto found = std::find_if(fixes.begin(), fixes.end(), [&](const Fix& fix) { return fix.robot == robot; });
    return found == fixes.end() ? Fix{} : *found;
}

double distance(const Fix& fix, const Pose2& truth) { return std::hypot(fix.pose.x - truth.x, fix.pose.y - truth.y); }

bool in_doubt(const Tracker& tracker, double time) {
    const auto fixes = tracker.fixes(from_seconds(time));
    return std::any_of(fixes.begin(), fixes.end(), [](const Fix& fix) { return fix.identity < sure; });
}

void judge_crossing(const Tracker& tracker, const std::array<Passage, 2>& ways, double time, bool doubtful, CrossingResult& result) {
    ++result.crossings;
    const auto fixes = tracker.fixes(from_seconds(time));
    const Fix first = named_fix(fixes, "r1");
    if (first.status == FixStatus::none || named_fix(fixes, "r2").status == FixStatus::none) {
        ++result.lost;
        return;
    }
    const bool switched = distance(first, ways[1].at(time)) < distance(first, ways[0].at(time));
    result.switches += switched;
    result.flagged += switched && doubtful;
    result.false_alarms += !switched && first.identity < sure;
}

}  // namespace roomfix
