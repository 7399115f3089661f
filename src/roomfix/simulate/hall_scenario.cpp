#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/random_vector.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {
namespace {

constexpr double floor_tile = 0.60;    // m, of the floor
constexpr double click_sigma = 0.5;    // px
constexpr double floor_per_robot = 8;  // m^2
constexpr double longest = 60;         // s: so long nobody runs into another

Eigen::Vector2d hall_size(int robots) {
    const double area = floor_per_robot * std::max(robots, 3);
    return {std::sqrt(area * 4 / 3), std::sqrt(area * 3 / 4)};
}

Solid box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, float albedo) {
    Solid solid;
    solid.centre = centre.cast<float>();
    solid.half = (0.5 * size).cast<float>();
    solid.side = {albedo, 0.08f, 0.03f};
    solid.top = {std::min(1.2f * albedo, 0.95f), 0.08f, 0.04f};
    return solid;
}

Solid can(double foot, double height, double diameter, float albedo) {
    Solid solid = box({0, 0, foot + 0.5 * height}, {diameter, diameter, height}, albedo);
    solid.round = true;
    return solid;
}

/// A kind of robot: what its user writes down, and what it looks like.
struct Kind {
    SiteRobot described;
    std::vector<Solid> solids;
};

float any_albedo(Random& random) { return static_cast<float>(random.uniform(0.06, 0.75)); }

/// A low base with a load and a thin mast, described by the box around it.
Kind rover(Random& random) {
    const double length = random.uniform(0.36, 0.50), width = random.uniform(0.28, 0.36), height = random.uniform(0.25, 0.45);
    Kind kind{{"", Box{length, width, height}}, {}};
    kind.described.drive = Drive::differential;
    const double base = random.uniform(0.35, 0.5) * height, load = random.uniform(0.2, 0.35) * height;
    kind.solids = {box({0, 0, 0.15 * base}, {0.9 * length, 0.95 * width, 0.3 * base}, 0.05f),
                   box({0, 0, 0.65 * base}, {length, width, 0.7 * base}, any_albedo(random)),
                   box({-0.12 * length, 0, base + 0.5 * load}, {0.6 * length, 0.8 * width, load}, any_albedo(random)),
                   box({0.35 * length, 0, 0.5 * (base + height)}, {0.04, 0.04, height - base}, any_albedo(random))};
    return kind;
}

/// A wide foot with a narrower column and a head, described by the cylinder around it.
Kind column(Random& random) {
    const double diameter = random.uniform(0.32, 0.42), height = random.uniform(0.35, 0.6);
    Kind kind{{"", Cylinder{diameter, height}}, {}};
    kind.described.drive = Drive::differential;
    kind.solids = {can(0.01, 0.3 * height, diameter, any_albedo(random)), can(0.3 * height, 0.45 * height, 0.7 * diameter, any_albedo(random)),
                   can(0.75 * height, 0.25 * height, 0.85 * diameter, any_albedo(random))};
    return kind;
}

/// A deck on wheels with four posts and something on it, described by the box around it.
Kind cart(Random& random) {
    const double length = random.uniform(0.6, 0.8), width = random.uniform(0.42, 0.55), height = random.uniform(0.8, 1.0);
    Kind kind{{"", Box{length, width, height}}, {}};
    kind.described.drive = Drive::differential;
    const float frame = any_albedo(random);
    kind.solids = {box({0, 0, 0.16}, {length, width, 0.12}, frame), box({-0.2 * length, 0, height - 0.02}, {0.5 * length, 0.9 * width, 0.04}, frame)};
    for (const double x : {-1.0, 1.0}) {
        for (const double y : {-1.0, 1.0}) {
            kind.solids.push_back(box({(-0.2 + 0.22 * x) * length, 0.42 * y * width, 0.5 * height}, {0.04, 0.04, height}, frame));
            kind.solids.push_back(box({0.4 * x * length, 0.4 * y * width, 0.05}, {0.1, 0.05, 0.1}, 0.05f));
        }
    }
    const double load = random.uniform(0.3, 0.6) * height;
    kind.solids.push_back(box({0.05 * length, 0.05 * width, 0.22 + 0.5 * load}, {0.7 * length, 0.75 * width, load}, any_albedo(random)));
    return kind;
}

Kind person(Random& random) {
    const auto clothes = [&] { return static_cast<float>(random.uniform(0.08, 0.6)); };
    Kind kind{{"", Cylinder{0.45, 1.75}}, {}};
    const float trousers = clothes();
    kind.solids = {can(0, 0.85, 0.16, trousers), can(0, 0.85, 0.16, trousers), can(0.85, 0.60, 0.40, clothes()), can(1.50, 0.25, 0.20, 0.45f)};
    for (Solid& solid : kind.solids) solid.side.grain = static_cast<float>(random.uniform(0.02, 0.3));  // clothes are smooth, or have folds and patterns
    kind.solids[0].centre.y() = 0.1f;
    kind.solids[1].centre.y() = -0.1f;
    return kind;
}

double radius_of(const ScenarioRobot& robot) { return half_size(robot.robot.shape).head<2>().norm(); }

/// Do two that drive around come too near to each other?
bool collide(const ScenarioRobot& a, const ScenarioRobot& b) {
    const double least = radius_of(a) + radius_of(b) + 0.1;
    for (double time = 0; time < longest; time += 0.2) {
        const Pose2 p = robot_pose(a, time), q = robot_pose(b, time);
        if (std::hypot(p.x - q.x, p.y - q.y) < least) return true;
    }
    return false;
}

/// A way around in the hall on which it meets nobody. Where there is none it stands where it is.
void find_way(ScenarioRobot& robot, const Eigen::Vector2d& size, const std::vector<const ScenarioRobot*>& others, Random& random) {
    constexpr int most_tries = 3000;
    const double margin = radius_of(robot) + 0.3;
    const auto somewhere = [&] { return Eigen::Vector2d(random.uniform(margin, size.x() - margin), random.uniform(margin, size.y() - margin)); };
    for (int attempt = 0; attempt < most_tries; ++attempt) {
        const Eigen::Vector2d middle = somewhere();
        robot.path.clear();
        const bool stands = attempt > most_tries / 2;
        const double reach = random.uniform(0.6, attempt < most_tries / 4 ? 2.0 : 1.0), turned = random.uniform(0, 2 * std::numbers::pi);
        for (int corner = 0; corner < (stands ? 1 : 5); ++corner) {
            const double angle = turned + 2 * std::numbers::pi * (corner + random.uniform(-0.25, 0.25)) / 5;
            const Eigen::Vector2d place = middle + reach * Eigen::Vector2d(std::cos(angle), std::sin(angle));
            robot.path.push_back(place.cwiseMax(margin).cwiseMin(size - Eigen::Vector2d::Constant(margin)));
        }
        robot.speed = random.uniform(0.25, 0.55);
        robot.start = random.uniform(0, 6);
        robot.pause_from = random.uniform(2, 8);
        robot.pause_to = robot.pause_from + random.uniform(0, 3);
        if (std::none_of(others.begin(), others.end(), [&](const ScenarioRobot* other) { return collide(robot, *other); })) return;
    }
}

ScenarioRobot robot_of(const Kind& kind, const std::string& id, Random& random) {
    ScenarioRobot robot;
    robot.robot = kind.described;
    robot.robot.id = id;
    robot.solids = kind.solids;
    WheelOdometry odometry;
    robot.robot.odometry = odometry;  // its wheels report, but the site file says no more of them than that they drive
    robot.wheels.scale = random.normal(odometry.scale_sigma);
    robot.wheels.drift = random.normal(odometry.drift_sigma);
    return robot;
}

/// Along the walls, evenly, each looking across the hall.
ScenarioCamera camera_of(int number, int count, const Eigen::Vector2d& size, Random& random) {
    const double around = 2 * (size.x() + size.y());
    double along = around * (number + 0.02 + 0.03 * random.uniform()) / count;
    Eigen::Vector2d place;
    if (along < size.x()) {
        place = {along, 0.05};
    } else if ((along -= size.x()) < size.y()) {
        place = {size.x() - 0.05, along};
    } else if ((along -= size.y()) < size.x()) {
        place = {size.x() - along, size.y() - 0.05};
    } else {
        place = {0.05, std::max(size.y() - (along - size.x()), 0.05)};
    }
    place = place.cwiseMax(0.05).cwiseMin(size - Eigen::Vector2d::Constant(0.05));
    const Eigen::Vector2d middle = 0.5 * size;
    const double far = std::min((middle - place).norm(), 4.5);  // m: in large halls each looks at its part
    const Eigen::Vector2d target = place + far * (middle - place).normalized();
    const double focal = random.uniform(410, 450);
    ScenarioCamera camera;
    camera.id = "hall" + std::to_string(number + 1);
    const CameraModel model = make_camera_model(640, 480, focal, focal, 320 + random.normal(3), 240 + random.normal(3), {random.uniform(-0.22, -0.15), 0.05});
    camera.truth = {model, {looking_at({place.x(), place.y(), random.uniform(2.7, 3.1)}, {target.x(), target.y(), 0.2}), Matrix6d::Zero()}};
    camera.sensor.read_noise = random.uniform(0.8, 1.6);
    camera.floor = {{Eigen::Vector2d::Constant(0.3), size - Eigen::Vector2d::Constant(0.3)}};
    return camera;
}

Scene empty_hall(const Eigen::Vector2d& size, const std::vector<Polyline>& walls, std::uint64_t seed, Random& random) {
    Scene scene;
    scene.seed = seed;
    scene.walls = panels_along(walls, 3.2f);
    scene.floor.tile = static_cast<float>(floor_tile);
    scene.floor.albedo = static_cast<float>(random.uniform(0.3, 0.6));
    scene.floor.variation = static_cast<float>(random.uniform(0.02, 0.08));
    scene.floor.reflection = static_cast<float>(random.uniform(0.0, 0.08));
    const int across = std::max(2, static_cast<int>(std::lround(size.x() / 4))), down = std::max(1, static_cast<int>(std::lround(size.y() / 4)));
    for (int i = 0; i < across * down; ++i) {
        const double x = size.x() * (i % across + 0.5) / across, y = size.y() * (i / across + 0.5) / down;
        scene.lamps.push_back({{static_cast<float>(x), static_cast<float>(y), 3.1f}, 3.0f, static_cast<float>(random.uniform(0.03, 0.3))});
    }
    return scene;
}

}  // namespace

Scenario hall_scenario(std::uint64_t seed, const HallSettings& settings) {
    Scenario scenario;
    scenario.name = scenario.site.name = "hall";
    Random random(seed ^ 0x4a11);
    const Eigen::Vector2d size = hall_size(settings.robots);
    scenario.site.walls = {{{0, 0}, {size.x(), 0}, size, {0, size.y()}, {0, 0}}};
    scenario.scene = empty_hall(size, scenario.site.walls, seed, random);
    for (int c = 0; c < settings.cameras; ++c) scenario.cameras.push_back(camera_of(c, settings.cameras, size, random));
    for (const ScenarioCamera& camera : scenario.cameras) {
        scenario.site.cameras.push_back(described_by_clicks(camera, floor_tile, click_sigma, 20, random));
    }
    const std::vector<Kind> kinds = {rover(random), column(random), cart(random)};
    const std::vector<std::string> names = {"rover", "column", "cart"};
    std::vector<int> of_kind(kinds.size(), 0);
    for (int r = 0; r < settings.robots; ++r) {
        const std::size_t kind = r % 6 < 3 ? 0 : r % 6 < 5 ? 1 : 2;  // three alike, two alike, and one more
        scenario.robots.push_back(robot_of(kinds[kind], names[kind] + std::to_string(++of_kind[kind]), random));
    }
    ScenarioRobot visitor;
    const Kind somebody = person(random);
    visitor.robot = somebody.described;
    visitor.solids = somebody.solids;
    scenario.others.push_back(visitor);
    std::vector<const ScenarioRobot*> placed;
    const auto place = [&](ScenarioRobot& robot) {
        find_way(robot, size, placed, random);
        placed.push_back(&robot);
    };
    // The largest first: later there is less room.
    for (const std::size_t kind : {2U, 0U, 1U}) {
        for (ScenarioRobot& robot : scenario.robots) {
            if (robot.robot.id.starts_with(names[kind])) place(robot);
        }
    }
    place(scenario.others[0]);
    for (const ScenarioRobot& robot : scenario.robots) {
        scenario.site.robots.push_back(robot.robot);
        scenario.site.robots.back().odometry.reset();
    }
    scenario.duration = 12;
    return scenario;
}

}  // namespace roomfix
