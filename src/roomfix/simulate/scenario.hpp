// Simulated sites with exact truth: what is there, who moves how, and which cameras look.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/random.hpp"
#include "roomfix/base/result.hpp"
#include "roomfix/observation/range_observation.hpp"
#include "roomfix/overhead/li2014.hpp"
#include "roomfix/simulate/camera_renderer.hpp"
#include "roomfix/simulate/ceiling_scene.hpp"
#include "roomfix/simulate/range_model.hpp"
#include "roomfix/simulate/room_scene.hpp"
#include "roomfix/simulate/scene.hpp"
#include "roomfix/simulate/wheel_simulator.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// A stretch of floor, m.
struct FloorArea {
    Eigen::Vector2d low, high;
};

struct ScenarioCamera {
    std::string id;
    View truth;  // true pose; its covariance is not used
    SensorModel sensor;
    std::vector<FloorArea> floor;  // floor whose tile corners somebody can click on in the picture
};

struct ScenarioRobot {
    SiteRobot robot;
    RobotLook look;
    std::vector<Eigen::Vector2d> path;  // m, closed; driven at constant speed, turning on the way
    double speed = 0.4;                 // m/s
    double start = 0;                   // m along the path at time 0
    double spin = 0;                    // rad/s, of a robot whose path is one point
    double until = 1e9;                 // s: then it is carried out of the building
    double pause_from = 0;              // s: it stands still ...
    double pause_to = 0;                // ... until then
    WheelModel wheels;                  // of a robot with odometry
    std::vector<Solid> solids;          // robot frame: what it really looks like; empty: as robot_solids() has it
};

/// A camera that rides on a robot and looks up.
struct ScenarioUpCamera {
    std::string id;
    std::size_t robot = 0;  // index in the scenario's robots
    CameraOnRobot truth;    // true mount; its covariance is not used
    SensorModel sensor;
    GlareModel glare;
};

/// A camera that looks for corners: it rides on a robot, or stands on a tripod that is carried around.
struct ScenarioEye {
    std::string id;
    std::size_t robot = 0;  // index in the scenario's robots
    CameraOnRobot truth;    // true mount; its covariance is not used
    SensorModel sensor;
    GlareModel glare;
    std::vector<Eigen::Isometry3d> stops;  // of a tripod: map_from_camera of frame after frame; the mount means nothing then
};

struct Scenario {
    std::string name;
    Site site;  // as its user would write it: cameras by clicked floor points, with clicking noise
    Scene scene;
    std::vector<ScenarioCamera> cameras;
    std::vector<ScenarioRobot> robots;
    std::vector<ScenarioRobot> others;  // people and things that the fixed cameras see, too; `unknown` in the truth
    CeilingScene ceiling;               // what the cameras that look up see
    std::vector<ScenarioUpCamera> up_cameras;
    RoomScene room;  // what the cameras that look for corners see
    std::vector<ScenarioEye> eyes;
    RangeModel ranges;      // of every robot with a receiver to every beacon
    double range_rate = 5;  // of each beacon, 1/s
    double frame_rate = 10;
    double duration = 60;
};

/// Every camera exposes its rows one after another, `readout` s from the first to the last, and the site file says so.
void roll_shutters(Scenario& scenario, double readout);
/// Every robot that drives does so at this speed (m/s).
void drive_at(Scenario& scenario, double speed);

/// Names of all scenarios.
std::vector<std::string> scenario_names();
struct HallSettings {
    int robots = 6;
    int cameras = 2;
};
/// `hall`: of the scenario of this name.
Result<Scenario> make_scenario(const std::string& name, std::uint64_t seed, const HallSettings& hall = {});

/// Li 2014: three aisles of 138, 150 and 152 cm, webcams at (279,570), (755,465) and (650,1030) cm, a robot of 54 x 54 cm.
Scenario li2014_scenario(std::uint64_t seed);
constexpr double li2014_tile = 0.30;  // m, of its floor; joints run through the map's origin
/// The same building with two robots of different size that drive through all three aisles, and a room beside it with a third robot whose
/// camera sees the room's corners.
Scenario demo_scenario(std::uint64_t seed);

/// A hall with a person and robots of three kinds, of every six three alike and two alike, none of them the solid that its description says. Sizes, looks,
/// ways, cameras, lamps and floor are drawn anew for each seed; 8 m^2 for each robot. On their ways, up to 60 s, nobody runs into another.
Scenario hall_scenario(std::uint64_t seed, const HallSettings& settings = {});

/// Kim 2011: a room under a ceiling of 3 m with a landmark at (1, 1.25) and beacons, a robot whose camera (352 x 288, half-angle 30 deg)
/// looks straight up; it drives through the six reference positions. `tilt` (rad) turns the true mount away from the one in the site.
Scenario kim2011_scenario(std::uint64_t seed, double tilt = 0);
/// The same room; the robot turns on the spot under the landmark's side.
Scenario kim2011_spin_scenario(std::uint64_t seed, double tilt = 0);
/// The same room; the robot drives around under the landmark, and its wheels report.
Scenario kim2011_drive_scenario(std::uint64_t seed, double tilt = 0);
/// The same room; the robot drives in circles at 1.2 m/s, its wheels report, and its mount is known exactly.
Scenario kim2011_fast_scenario(std::uint64_t seed);
/// The paper's reference positions and the errors printed for them, Table 1, m.
struct Kim2011Position {
    Eigen::Vector2d place;
    double trilateration, proposed;
};
const std::vector<Kim2011Position>& kim2011_positions();

/// Chou and Tsai 1986: a tripod camera (640 x 480) in a room, 16 places, six pictures each; `cluttered` furnishes the room.
Scenario chou1986_scenario(std::uint64_t seed, bool cluttered = false);

/// Where an eye is at a time (s).
Eigen::Isometry3d eye_pose(const Scenario& scenario, const ScenarioEye& eye, double time);
/// Where a robot of the scenario is, be it a tripod.
Pose2 true_pose(const Scenario& scenario, std::size_t robot, double time);

/// A lamp somewhere over the robot: a lit tube of 0.6 to 1.5 m, anywhere or right along the edge of the landmark's panel.
CeilingPatch random_tube(const Eigen::Vector2d& around, double spread, Random& random);
CeilingPatch tube_at_panel(const SiteLandmark& landmark, const LandmarkLook& look, Random& random);

/// What a robot's receiver hears between two times (s): each beacon `range_rate` times a second, unless a wall stands between.
std::vector<RangeObservation> heard_ranges(const Scenario& scenario, std::size_t robot, double from, double to, std::uint64_t seed);

/// The wheels of one of its robots.
WheelSimulator wheels_of(const Scenario& scenario, std::size_t robot, std::uint64_t seed);

/// Straight up, `height` above the robot's centre; the picture's top is the robot's front.
Eigen::Isometry3d looking_up(double height);

/// Where a robot of the scenario is at a time (s).
Pose2 robot_pose(const ScenarioRobot& robot, double time);

/// Floor points of a camera as somebody would click them: visible tile corners, each coordinate with normal noise (px).
std::vector<FloorPoint> clicked_floor_points(const ScenarioCamera& camera, double tile, double sigma, int most, Random& random);

/// The same as its user would describe it: placed by such clicks, with its files in a session's folders.
SiteCamera described_by_clicks(const ScenarioCamera& camera, double tile, double sigma, int most, Random& random);

/// The room's light at a time (1 = nominal): slow drift, different for each seed.
double light_at(double time, std::uint64_t seed);

/// The paper's Table 1.
struct Li2014TestPoint {
    int camera;                // 0, 1, 2
    Eigen::Vector2d actual;    // m
    Eigen::Vector2d measured;  // m, as printed
    double printed_error;      // m, as printed
};
const std::vector<Li2014TestPoint>& li2014_test_points();

/// The rectangle of floor tiles (0.9 x 2.4 m) that sets up the published method for a camera of the li2014 scenario,
/// clicked with noise (px).
Li2014Rectangle li2014_rectangle(const ScenarioCamera& camera, double sigma, Random& random);

}  // namespace roomfix
