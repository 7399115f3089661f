#include <cmath>

#include "roomfix/base/random_vector.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {
namespace {

// The three aisles, m. The paper gives their widths, the webcams and the test points; the walls are placed so that the
// robot fits between them at every test point. Point (1001, 779) lies in none of the aisles, so there is an open bay.
constexpr double tile = li2014_tile;
constexpr double clicking_noise = 0.5;  // px
const std::vector<Polyline> li2014_walls = {
    {{2.30, 5.01}, {2.30, 6.39}},                                                             // end of aisle 1
    {{2.30, 6.39}, {6.95, 6.39}, {6.95, 9.66}, {6.20, 9.66}, {6.20, 11.18}, {13.60, 11.18}},  // left of all aisles
    {{2.30, 5.01}, {6.95, 5.01}, {6.95, 4.40}, {8.45, 4.40}, {8.45, 7.20}, {10.90, 7.20}},    // right, up to the bay
    {{10.90, 7.20}, {10.90, 9.66}, {13.60, 9.66}, {13.60, 11.18}},                            // right of aisle 3
};

View camera_view(const CameraModel& model, const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
    return {model, {looking_at(position, target), Matrix6d::Zero()}};
}

std::vector<ScenarioCamera> webcams() {
    // Lens numbers of webcams 1 and 2 are the paper's; its image centre of webcam 1 lies outside the picture and webcam 3's
    // numbers belong to another resolution, so these are plausible ones.
    std::vector<ScenarioCamera> cameras(3);
    cameras[0] = {"hall1",
                  camera_view(make_camera_model(640, 480, 518.38, 518.07, 318.0, 239.5, {0.0895, -0.7064, -0.0034, 0.0020, 1.3227}), {2.79, 5.70, 2.30},
                              {6.45, 5.70, 0.1}),
                  {},
                  {{{4.7, 5.05}, {8.3, 6.35}}}};
    cameras[1] = {"hall2",
                  camera_view(make_camera_model(640, 480, 598.36, 600.76, 318.0, 264.19, {0.2460, -1.8737, -0.0023, -0.0043, 5.4119}), {7.55, 4.65, 2.40},
                              {7.55, 9.00, 0.1}),
                  {},
                  {{{7.0, 6.7}, {8.4, 11.0}}}};
    cameras[2] = {
        "hall3",
        camera_view(make_camera_model(480, 360, 295.0, 294.5, 238.0, 181.0, {-0.10, 0.01, 0.0008, -0.0006, 0.0}), {6.50, 10.30, 2.45}, {10.6, 10.30, 0.1}),
        {},
        {{{8.3, 9.7}, {13.2, 11.1}}, {{8.8, 7.6}, {10.7, 9.6}}}};
    cameras[1].sensor.read_noise = 1.0;
    cameras[2].sensor.read_noise = 1.6;
    cameras[2].sensor.blur = 0.8;
    return cameras;
}

Scene building(std::uint64_t seed) {
    Scene scene;
    scene.seed = seed;
    scene.walls = panels_along(li2014_walls, 2.8f);
    for (const auto& [x, y] : {std::pair{4.0f, 5.7f}, {6.6f, 5.7f}, {7.7f, 7.6f}, {7.7f, 10.4f}, {10.2f, 10.4f}, {12.6f, 10.4f}, {9.7f, 8.4f}}) {
        scene.lamps.push_back({{x, y, 2.75f}, 2.2f, 0.06f});
    }
    return scene;
}

Site site_of(const std::string& name, const std::vector<ScenarioCamera>& cameras, std::uint64_t seed) {
    Site site;
    site.name = name;
    site.ceiling = 2.8;
    site.walls = li2014_walls;
    Random random(seed ^ 0xca11b);
    for (const ScenarioCamera& camera : cameras) {
        site.cameras.push_back(described_by_clicks(camera, tile, clicking_noise, 24, random));
    }
    return site;
}

ScenarioRobot paper_robot(std::uint64_t seed) {
    ScenarioRobot robot;
    robot.robot = {"r1", Box{0.54, 0.54, 0.45}};
    robot.robot.size_sigma = 0.003;  // as its maker says, and as it is
    Random random(seed ^ 0x40b07);
    const auto off = [&] { return random.normal(robot.robot.size_sigma); };
    robot.look.size_error = {off(), off(), off()};
    robot.robot.drive = Drive::differential;
    WheelOdometry odometry;
    odometry.source = "odometry.csv";
    robot.robot.odometry = odometry;
    robot.wheels.scale = random.normal(odometry.scale_sigma);
    robot.wheels.drift = random.normal(odometry.drift_sigma);
    // There on the right side of the aisles, back on the other: no robot turns around in no time.
    robot.path = {{4.9, 5.50}, {7.90, 5.50}, {7.90, 10.20}, {12.5, 10.20}, {12.5, 10.65}, {7.45, 10.65}, {7.45, 5.95}, {4.9, 5.95}};
    return robot;
}

}  // namespace

Scenario li2014_scenario(std::uint64_t seed) {
    Scenario scenario;
    scenario.name = "li2014";
    scenario.cameras = webcams();
    scenario.scene = building(seed);
    scenario.site = site_of("li2014", scenario.cameras, seed);
    scenario.robots = {paper_robot(seed)};
    scenario.site.robots = {scenario.robots[0].robot};
    return scenario;
}

namespace {

/// Landmarks and beacons along the aisles' ceiling, and a camera and a receiver on the first robot.
void equip_with_landmarks(Scenario& scenario) {
    constexpr double height = 2.8;  // m
    scenario.ceiling.height = height;
    scenario.ceiling.seed = scenario.scene.seed;
    for (const Lamp& lamp : scenario.scene.lamps) {
        CeilingPatch tube;
        tube.centre = lamp.position.head<2>().cast<double>() + Eigen::Vector2d(0.4, 0.4);
        tube.half = {0.6, 0.013};
        tube.light = 15;
        scenario.ceiling.patches.push_back(tube);
    }
    const std::vector<Eigen::Vector2d> places = {{5.2, 5.6}, {7.6, 5.9}, {7.8, 8.2}, {7.5, 10.5}, {10.0, 10.3}, {12.3, 10.5}};
    for (std::size_t i = 0; i < places.size(); ++i) {
        const std::string id = "n" + std::to_string(i + 1);
        const Eigen::Vector3d place(places[i].x(), places[i].y(), height);
        SiteLandmark landmark{id, LedTriangle{0.10, 0.15}};
        landmark.map_from_landmark = Eigen::Translation3d(place) * Eigen::AngleAxisd(radians(30.0 * static_cast<double>(i)), Eigen::Vector3d::UnitZ());
        landmark.beacon = id;
        scenario.site.landmarks.push_back(landmark);
        scenario.site.beacons.push_back({id, place, ""});
        add_landmark(landmark, {}, scenario.ceiling);
    }
    ScenarioRobot& robot = scenario.robots[0];
    const double top = half_size(robot.robot.shape).z() * 2;
    robot.robot.receivers = {Receiver{{0, 0, top}, "ranges.csv", scenario.ranges.sigma}};
    const double focal = 0.5 * 352 / std::tan(radians(30));
    const CameraModel model = make_camera_model(352, 288, focal, focal, 175.1, 144.2, {-0.08, 0.02, 0.0006, -0.0004, 0});
    const UncertainPose3 mount{looking_up(top), (Vector6d() << 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6).finished().asDiagonal()};
    scenario.site.cameras.push_back({"up", "frames/up", model, Mount{robot.robot.id, mount, true}, ""});
    scenario.up_cameras.push_back({"up", 0, {model, {looking_up(top), Matrix6d::Zero()}}, {}, {}});
}

/// A room beside the aisles, with a robot that finds itself by the room's corners; ranges to two beacons tell which of four alike it sees.
void add_room(Scenario& scenario) {
    constexpr double left = 14.4, right = 19.4, low = 5.4, high = 9.8, height = 2.7;  // m
    scenario.room.walls = {{left, low}, {right, low}, {right, high}, {left, high}};
    scenario.room.wall_albedo = {0.62f, 0.42f, 0.58f, 0.40f};
    scenario.room.height = height;
    scenario.room.seed = scenario.scene.seed;
    scenario.room.lamps = {{{16.6, 7.4, 2.2}, 0.5f}, {{19.0, 6.4, 1.4}, 0.6f}};
    scenario.room.patches = {{3, {1.2, 1.0}, {2.2, 1.8}, 0.25f, 0, 0.03, 0.8f, 0.1}, {0, {2.6, 0.0}, {3.5, 2.05}, 0.3f, 0, 0.08, 0.85f, 0}};
    scenario.room.boxes = {{{14.75, 8.2, 0.9}, {0.3, 0.6, 0.9}, 0, 0.2f}};
    Site& site = scenario.site;
    site.walls.push_back({{left, low}, {right, low}, {right, high}, {left, high}, {left, low}});
    site.corners = {{"sw", {left, low, height}, 0},
                    {"se", {right, low, height}, radians(90)},
                    {"ne", {right, high, height}, radians(180)},
                    {"nw", {left, high, height}, radians(-90)}};
    for (SiteCorner& corner : site.corners) corner.moulding = 0;
    site.beacons.push_back({"b1", {15.2, 5.5, 2.4}, ""});
    site.beacons.push_back({"b2", {19.3, 8.9, 2.4}, ""});
    ScenarioRobot scout;
    constexpr double mast = 0.5;  // m
    scout.robot = {"scout", Cylinder{0.40, mast}};
    scout.robot.receivers = {Receiver{{0, 0, mast}, "ranges.csv", scenario.ranges.sigma}};
    scout.path = {{16.0, 6.9}, {18.1, 6.9}, {18.1, 8.3}, {16.0, 8.3}};
    scout.speed = 0.25;
    const CameraModel model = make_camera_model(480, 360, 320, 320, 241.3, 178.6, {-0.09, 0.03, 0.0004, -0.0005, 0});
    UncertainPose3 mount;
    mount.pose = looking_at({0, 0, mast}, {1, 0, mast + 0.5});
    mount.covariance = (Vector6d() << 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6).finished().asDiagonal();
    site.cameras.push_back({"eye", "frames/eye", model, Mount{scout.robot.id, mount, true}, ""});
    SensorModel sensor;
    sensor.exposure = 1.3;
    sensor.read_noise = 1;
    sensor.shot_noise = 0.02;
    scenario.eyes.push_back({"eye", scenario.robots.size(), {model, {mount.pose, Matrix6d::Zero()}}, sensor, {}, {}});
    scenario.robots.push_back(scout);
    site.robots.push_back(scout.robot);
}

}  // namespace

Scenario demo_scenario(std::uint64_t seed) {
    Scenario scenario = li2014_scenario(seed);
    scenario.name = scenario.site.name = "demo";
    equip_with_landmarks(scenario);
    scenario.site.robots = {scenario.robots[0].robot};
    scenario.robots[0].path = {{4.9, 5.50}, {7.90, 5.50}, {7.90, 8.60}, {7.45, 8.60}, {7.45, 5.95}, {4.9, 5.95}};
    Random random(seed ^ 0xde30);
    const auto with_wheels = [&](ScenarioRobot robot) {
        robot.robot.drive = Drive::differential;
        WheelOdometry odometry;
        odometry.source = "odometry.csv";
        robot.robot.odometry = odometry;
        robot.wheels.scale = random.normal(0.01);
        robot.wheels.drift = random.normal(0.01);
        scenario.robots.push_back(robot);
        scenario.site.robots.push_back(robot.robot);
    };
    // A cart whose way leads through a side room that no camera sees.
    ScenarioRobot cart;
    cart.robot = {"cart", Box{0.80, 0.50, 0.60}};
    cart.look = {0.10f, 0.08f, false};
    cart.path = {{9.55, 8.3}, {9.95, 8.3}, {9.95, 10.65}, {8.8, 10.65}, {8.8, 10.2}, {9.55, 10.2}};
    cart.speed = 0.3;
    with_wheels(cart);
    // Two that look the same and pass each other again and again.
    for (const char* id : {"a1", "a2"}) {
        ScenarioRobot twin;
        twin.robot = {id, Box{0.46, 0.34, 0.35}};
        twin.look = {0.62f, 0.12f, false};
        twin.path = {{10.7, 10.22}, {12.5, 10.22}, {12.5, 10.64}, {10.7, 10.64}};
        twin.speed = 0.25;
        twin.start = id == std::string("a1") ? 0 : 2.2;
        with_wheels(twin);
    }
    add_room(scenario);
    scenario.duration = 90;
    return scenario;
}

const std::vector<Li2014TestPoint>& li2014_test_points() {
    static const std::vector<Li2014TestPoint> points = {
        {0, {6.10, 5.92}, {6.13, 5.88}, 0.0500},     {0, {6.27, 6.11}, {6.26, 6.09}, 0.0224},     {0, {6.36, 5.60}, {6.30, 5.59}, 0.0808},
        {0, {6.48, 5.91}, {6.41, 5.94}, 0.0762},     {0, {6.84, 5.84}, {6.76, 5.78}, 0.1000},     {1, {7.36, 8.91}, {7.38, 8.83}, 0.0824},
        {1, {7.74, 9.12}, {7.75, 9.01}, 0.1104},     {1, {7.59, 9.18}, {7.56, 9.06}, 0.1237},     {1, {7.63, 9.44}, {7.59, 9.32}, 0.1265},
        {1, {8.08, 9.66}, {8.11, 9.52}, 0.1237},     {2, {10.01, 7.79}, {9.97, 7.79}, 0.0400},    {2, {12.36, 10.76}, {12.25, 10.74}, 0.1118},
        {2, {12.50, 10.19}, {12.41, 10.21}, 0.0949}, {2, {12.71, 10.63}, {12.62, 10.65}, 0.1118}, {2, {12.50, 10.41}, {12.41, 10.39}, 0.0922}};
    return points;
}

Li2014Rectangle li2014_rectangle(const ScenarioCamera& camera, double sigma, Random& random) {
    // The tile corners next to the camera's axis, from a near row on, 3 tiles wide and 8 long.
    const Li2014Aisle aisle = li2014_aisle_ahead(camera.truth);
    const Eigen::Vector2d left(-aisle.direction.y(), aisle.direction.x());
    const auto grid = [](double along) { return std::round(along / tile) * tile; };
    const double axis = grid(left.dot(aisle.camera) - 0.5 * tile) + 0.5 * tile;  // the aisle's axis runs through a tile's middle
    const double first = grid(aisle.direction.dot(aisle.camera) + 2.4);
    Li2014Rectangle rectangle;
    rectangle.width = 3 * tile;
    rectangle.length = 8 * tile;
    rectangle.near_distance = first - aisle.direction.dot(aisle.camera);
    rectangle.left_offset = axis + 1.5 * tile - left.dot(aisle.camera);
    const auto clicked = [&](double along, double across) {
        const Eigen::Vector2d p = along * aisle.direction + across * left;
        const auto pixel = project_map_point(camera.truth, {p.x(), p.y(), 0});
        return Eigen::Vector2d(pixel.value_or(Eigen::Vector2d::Zero()) + normal2(random, sigma));
    };
    rectangle.left_near = clicked(first, axis + 1.5 * tile);
    rectangle.left_far = clicked(first + 8 * tile, axis + 1.5 * tile);
    rectangle.right_near = clicked(first, axis - 1.5 * tile);
    rectangle.right_far = clicked(first + 8 * tile, axis - 1.5 * tile);
    return rectangle;
}

}  // namespace roomfix
