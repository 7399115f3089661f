#include <cmath>
#include <numbers>

#include "roomfix/base/random_vector.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {
namespace {

// The paper gives the picture's size, the ceiling (3 m), the half-angle (30 deg: 3.5 x 2.8 m of ceiling in view), the landmark's legs
// and six reference positions; it says that nodes hang so far apart that only one is in view.
constexpr double ceiling = 3.0;         // m
constexpr double camera_height = 0.30;  // m
constexpr double tape_error = 0.005;    // m
const Eigen::Vector2d landmark_place(1.0, 1.25);

CameraModel usb_camera() {
    const double focal = 0.5 * 352 / std::tan(radians(30));
    return make_camera_model(352, 288, focal, focal, 175.1, 144.2, {-0.08, 0.02, 0.0006, -0.0004, 0});
}

Scenario room(const char* name, std::uint64_t seed, double tilt) {
    Scenario scenario;
    scenario.name = scenario.site.name = name;
    Site& site = scenario.site;
    site.ceiling = ceiling;
    site.walls = {{{-1.5, -1.0}, {6.0, -1.0}, {6.0, 5.5}, {-1.5, 5.5}, {-1.5, -1.0}}};
    site.beacons = {{"n1", {landmark_place.x(), landmark_place.y(), ceiling}, ""},
                    {"n2", {5.0, 1.25, ceiling}, ""},
                    {"n3", {1.0, 4.4, ceiling}, ""},
                    {"n4", {5.0, 4.4, ceiling}, ""}};
    SiteLandmark landmark{"n1", LedTriangle{0.10, 0.15}};
    landmark.map_from_landmark = Eigen::Translation3d(landmark_place.x(), landmark_place.y(), ceiling) * Eigen::AngleAxisd(0, Eigen::Vector3d::UnitZ());
    landmark.sigma = 0;  // the map is defined by it: the reference positions were marked out from it
    landmark.beacon = "n1";
    site.landmarks = {landmark};

    SiteRobot robot{"r1", Cylinder{0.40, 0.30}};
    robot.receivers = {Receiver{{0, 0, camera_height}, "ranges.csv", scenario.ranges.sigma}};
    site.robots = {robot};
    SiteCamera up{"up", "frames/up", usb_camera(), Mount{"r1", {looking_up(camera_height), Matrix6d::Zero()}, false}, ""};
    site.cameras = {up};

    // The room as it is.
    Random random(seed ^ 0x9011);
    scenario.ceiling.height = ceiling;
    scenario.ceiling.seed = seed;
    add_landmark(landmark, {}, scenario.ceiling);
    scenario.ranges.temperature = site.temperature;
    scenario.ranges.temperature_error = random.normal(1.0);
    ScenarioUpCamera camera{"up", 0, {up.model, {looking_up(camera_height), Matrix6d::Zero()}}, {}, {}};
    const double direction = random.uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Vector3d axis(std::cos(direction), std::sin(direction), 0);
    camera.truth.robot_from_camera.pose.linear() = exponential_rotation(tilt * axis) * looking_up(camera_height).linear();
    if (tilt > 0) {  // and somebody measured its place with a tape
        const auto off = [&] { return random.normal(tape_error); };
        camera.truth.robot_from_camera.pose.translation() += Eigen::Vector3d(off(), off(), off());
    }
    scenario.up_cameras = {camera};
    scenario.robots = {{robot, {}, {}, 0.2, 0, 0}};
    return scenario;
}

/// Wheels that report, and err as usual. Returns the random numbers that come next.
Random give_wheels(ScenarioRobot& robot, std::uint64_t seed) {
    WheelOdometry odometry;
    odometry.source = "odometry.csv";
    robot.robot.drive = Drive::differential;
    robot.robot.odometry = odometry;
    Random random(seed ^ 0x0d0);
    robot.wheels.scale = random.normal(odometry.scale_sigma);
    robot.wheels.drift = random.normal(odometry.drift_sigma);
    return random;
}

}  // namespace

Scenario kim2011_scenario(std::uint64_t seed, double tilt) {
    Scenario scenario = room("kim2011", seed, tilt);
    Random random(seed ^ 0x71be);
    scenario.ceiling.patches.insert(scenario.ceiling.patches.begin(), random_tube(landmark_place, 1.2, random));
    scenario.robots[0].path = {{0.5, 1.0}, {1.5, 1.0}, {1.5, 1.5}, {0.5, 1.5}};
    scenario.duration = 20;
    return scenario;
}

Scenario kim2011_spin_scenario(std::uint64_t seed, double tilt) {
    Scenario scenario = room("kim2011-spin", seed, tilt);
    scenario.robots[0].path = {{1.35, 1.05}};
    scenario.robots[0].spin = 0.5;
    scenario.duration = 14;
    return scenario;
}

Scenario kim2011_fast_scenario(std::uint64_t seed) {
    Scenario scenario = room("kim2011-fast", seed, 0);
    ScenarioRobot& robot = scenario.robots[0];
    constexpr int points = 48;
    constexpr double radius = 0.75;  // m: 1.6 rad/s
    for (int i = 0; i < points; ++i) {
        const double angle = 2 * std::numbers::pi * i / points;
        robot.path.emplace_back(landmark_place.x() + 0.2 + radius * std::cos(angle), landmark_place.y() + radius * std::sin(angle));
    }
    robot.speed = 1.2;
    (void)give_wheels(robot, seed);
    scenario.site.robots = {robot.robot};
    scenario.duration = 10;
    return scenario;
}

Scenario kim2011_drive_scenario(std::uint64_t seed, double tilt) {
    Scenario scenario = room("kim2011-drive", seed, tilt);
    ScenarioRobot& robot = scenario.robots[0];
    robot.path = {{0.3, 0.8}, {1.8, 0.8}, {1.8, 1.8}, {1.05, 1.3}, {0.3, 1.8}};
    robot.speed = 0.25;
    Random random = give_wheels(robot, seed);
    scenario.site.robots = {robot.robot};
    Eigen::Isometry3d& mount = scenario.up_cameras[0].truth.robot_from_camera.pose;  // set by eye
    mount.linear() = Eigen::AngleAxisd(random.normal(radians(1)), Eigen::Vector3d::UnitZ()).toRotationMatrix() * mount.linear();
    scenario.duration = 22;  // once around
    return scenario;
}

const std::vector<Kim2011Position>& kim2011_positions() {
    static const std::vector<Kim2011Position> positions = {{{0.5, 1.0}, 0.05410, 0.02086}, {{1.0, 1.0}, 0.08250, 0.01718}, {{1.5, 1.0}, 0.04867, 0.01964},
                                                           {{0.5, 1.5}, 0.02785, 0.03093}, {{1.0, 1.5}, 0.08237, 0.01074}, {{1.5, 1.5}, 0.06282, 0.03011}};
    return positions;
}

CeilingPatch random_tube(const Eigen::Vector2d& around, double spread, Random& random) {
    CeilingPatch tube;
    tube.centre = around + uniform2(random, {-spread, -spread}, {spread, spread});
    tube.half = {0.5 * random.uniform(0.6, 1.5), 0.5 * random.uniform(0.016, 0.04)};
    tube.yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
    tube.light = static_cast<float>(random.uniform(5, 25));
    return tube;
}

CeilingPatch tube_at_panel(const SiteLandmark& landmark, const LandmarkLook& look, Random& random) {
    const auto& triangle = std::get<LedTriangle>(landmark.kind);
    const Eigen::Isometry3d& pose = landmark.map_from_landmark;
    CeilingPatch tube = random_tube({0, 0}, 0, random);
    const Eigen::Vector2d half(triangle.a / 2 + look.margin, triangle.b / 2 + look.margin);
    const bool along_a = random.index(2) == 0;
    const double side = random.index(2) == 0 ? 1 : -1;
    const double slide = random.uniform(-0.6, 0.6);
    const Eigen::Vector2d own = along_a ? Eigen::Vector2d(slide, side * (half.y() + tube.half.y())) : Eigen::Vector2d(side * (half.x() + tube.half.y()), slide);
    tube.centre = (pose * Eigen::Vector3d(own.x(), own.y(), 0)).head<2>();
    tube.yaw = std::atan2(pose.linear()(1, 0), pose.linear()(0, 0)) + (along_a ? 0 : std::numbers::pi / 2);
    return tube;
}

}  // namespace roomfix
