#include "roomfix/simulate/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/random_vector.hpp"

namespace roomfix {

std::vector<std::string> scenario_names() {
    return {"li2014", "kim2011", "kim2011-spin", "kim2011-drive", "kim2011-fast", "chou1986", "chou1986-cluttered", "demo", "hall"};
}

Result<Scenario> make_scenario(const std::string& name, std::uint64_t seed, const HallSettings& hall) {
    if (name == "li2014") return li2014_scenario(seed);
    if (name == "kim2011") return kim2011_scenario(seed);
    if (name == "kim2011-spin") return kim2011_spin_scenario(seed, radians(0.5));
    if (name == "kim2011-drive") return kim2011_drive_scenario(seed, radians(0.5));
    if (name == "kim2011-fast") return kim2011_fast_scenario(seed);
    if (name == "chou1986") return chou1986_scenario(seed);
    if (name == "chou1986-cluttered") return chou1986_scenario(seed, true);
    if (name == "demo") return demo_scenario(seed);
    if (name == "hall") return hall_scenario(seed, hall);
    return Error{fmt::format("there is no scenario '{}': choose one of {}", name, fmt::join(scenario_names(), ", "))};
}

void roll_shutters(Scenario& scenario, double readout) {
    for (ScenarioCamera& camera : scenario.cameras) camera.sensor.readout = readout;
    for (ScenarioUpCamera& camera : scenario.up_cameras) camera.sensor.readout = readout;
    for (ScenarioEye& eye : scenario.eyes) eye.sensor.readout = readout;
    for (SiteCamera& camera : scenario.site.cameras) camera.capture.readout = readout;
}

void drive_at(Scenario& scenario, double speed) {
    for (ScenarioRobot& robot : scenario.robots) robot.speed = speed;
}

Pose2 robot_pose(const ScenarioRobot& robot, double time) {
    const auto& path = robot.path;
    if (path.empty()) return {};
    if (path.size() == 1) return {path[0].x(), path[0].y(), wrap_angle(robot.spin * time)};
    double length = 0;
    for (std::size_t i = 0; i < path.size(); ++i) length += (path[(i + 1) % path.size()] - path[i]).norm();
    const auto place = [&](double along) {
        along = std::fmod(along, length);
        if (along < 0) along += length;
        for (std::size_t i = 0;; i = (i + 1) % path.size()) {
            const Eigen::Vector2d leg = path[(i + 1) % path.size()] - path[i];
            if (along <= leg.norm()) return Eigen::Vector2d(path[i] + leg.normalized() * along);
            along -= leg.norm();
        }
    };
    // The nose follows the path half a robot ahead, so that corners are driven, not jumped.
    constexpr double reach = 0.35;
    const double paused = std::clamp(time - robot.pause_from, 0.0, robot.pause_to - robot.pause_from);
    const double along = robot.start + robot.speed * (time - paused);
    const Eigen::Vector2d nose = place(along + reach);
    const Eigen::Vector2d tail = place(along - reach);
    const Eigen::Vector2d middle = 0.5 * (nose + tail);
    const Eigen::Vector2d heading = nose - tail;
    // At a turning point nose and tail meet: keep the direction of the leg.
    const Eigen::Vector2d leg = place(along + 1e-3) - place(along - 1e-3);
    const Eigen::Vector2d d = heading.norm() > 0.05 ? heading : leg;
    return {middle.x(), middle.y(), std::atan2(d.y(), d.x())};
}

std::vector<FloorPoint> clicked_floor_points(const ScenarioCamera& camera, double tile, double sigma, int most, Random& random) {
    std::vector<FloorPoint> all;
    for (const FloorArea& area : camera.floor) {
        for (double y = std::ceil(area.low.y() / tile) * tile; y <= area.high.y(); y += tile) {
            for (double x = std::ceil(area.low.x() / tile) * tile; x <= area.high.x(); x += tile) {
                const auto pixel = project_map_point(camera.truth, {x, y, 0});
                if (pixel && camera.truth.model.contains(*pixel, 4)) all.push_back({*pixel, {x, y}});
            }
        }
    }
    std::vector<FloorPoint> chosen;
    const double step = std::max(1.0, static_cast<double>(all.size()) / most);
    for (double i = 0; i < static_cast<double>(all.size()); i += step) {
        FloorPoint point = all[static_cast<std::size_t>(i)];
        point.pixel += normal2(random, sigma);
        chosen.push_back(point);
    }
    return chosen;
}

Eigen::Isometry3d looking_up(double height) {
    Eigen::Isometry3d mount = Eigen::Isometry3d::Identity();
    mount.linear().col(0) = Eigen::Vector3d::UnitY();
    mount.linear().col(1) = -Eigen::Vector3d::UnitX();
    mount.linear().col(2) = Eigen::Vector3d::UnitZ();
    mount.translation() = Eigen::Vector3d(0, 0, height);
    return mount;
}

std::vector<RangeObservation> heard_ranges(const Scenario& scenario, std::size_t robot, double from, double to, std::uint64_t seed) {
    std::vector<RangeObservation> ranges;
    const Receiver* receiver = scenario.robots[robot].robot.receiver();
    if (!receiver) return ranges;
    const double interval = 1 / scenario.range_rate;
    const double count = static_cast<double>(scenario.site.beacons.size());
    for (std::size_t b = 0; b < scenario.site.beacons.size(); ++b) {
        const double turn = interval * static_cast<double>(b) / count;  // beacons speak one after another
        for (double k = std::ceil((from - turn) / interval); k * interval + turn < to; ++k) {
            const double time = k * interval + turn;
            const Eigen::Vector3d place = map_from_robot(robot_pose(scenario.robots[robot], time)) * receiver->position;
            const Eigen::Vector3d& beacon = scenario.site.beacons[b].position;
            Random random(mix64(seed ^ mix64(robot * 1000 + b)) + static_cast<std::uint64_t>(k));
            const auto message = hear(scenario.ranges, (beacon - place).norm(), random);
            if (!message || wall_between(scenario.site.walls, beacon.head<2>(), place.head<2>())) continue;
            const double speed = 331.3 * std::sqrt(1 + scenario.site.temperature / 273.15);
            ranges.push_back({from_seconds(time), static_cast<int>(robot), static_cast<int>(b), message->flight_time * speed, receiver->sigma});
        }
    }
    std::stable_sort(ranges.begin(), ranges.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
    return ranges;
}

WheelSimulator wheels_of(const Scenario& scenario, std::size_t robot, std::uint64_t seed) {
    const ScenarioRobot& driven = scenario.robots[robot];
    return {driven.wheels, [driven](double time) { return robot_pose(driven, time); }, seed * 43 + robot};
}

SiteCamera described_by_clicks(const ScenarioCamera& camera, double tile, double sigma, int most, Random& random) {
    SiteCamera described;
    described.id = camera.id;
    described.source = "frames/" + camera.id;
    described.background = "background/" + camera.id;
    described.model = camera.truth.model;
    described.placement = KnownFloorPoints{clicked_floor_points(camera, tile, sigma, most, random), sigma};
    return described;
}

double light_at(double time, std::uint64_t seed) {
    Random random(seed ^ 0x11687);
    double light = 1;
    for (const double period : {37.0, 11.0, 4.3}) {
        light += 0.01 * std::sin(2 * std::numbers::pi * (time / period + random.uniform()));
    }
    return light;
}

}  // namespace roomfix
