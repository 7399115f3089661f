#include "roomfix/evaluate/simulated_calibration.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "roomfix/base/random_vector.hpp"
#include "roomfix/calibrate/tile_grid.hpp"
#include "roomfix/ceiling/ceiling_observer.hpp"
#include "roomfix/ceiling/robot_locator.hpp"
#include "roomfix/evaluate/simulated_boards.hpp"

namespace roomfix {
namespace {

const Chessboard printed_board{11, 8, 0.020};  // fills a sheet of A4
constexpr int spin_frames = 90;
constexpr double spot_wobble = 0.002;   // m
constexpr double frame_interval = 0.2;  // s, of a drive

/// A frame as seen_turn() and seen_drive() give it. Nothing where an LED is out of sight.
std::optional<MountFrame> seen_from(const CameraOnRobot& truth, const Pose2& pose, const std::vector<Eigen::Vector3d>& leds, double noise, Random& random) {
    MountFrame frame;
    frame.pose = {pose.x + random.normal(0.02), pose.y + random.normal(0.02), wrap_angle(pose.yaw + random.normal(0.02))};
    for (const Eigen::Vector3d& led : leds) {
        const auto pixel = predict_point(truth, pose, led);
        if (!pixel || !truth.model.contains(*pixel)) return std::nullopt;
        const Eigen::Vector2d off = normal2(random, noise);
        frame.points.push_back({led, *pixel + off, noise * noise * Eigen::Matrix2d::Identity(), 0, 0});
    }
    return frame;
}

}  // namespace

Result<LensCalibration> photographed_lens(const CameraModel& truth, const SensorModel& sensor, std::uint64_t seed, const BoardPictures& pictures) {
    Random random(seed * 6151 + 17);
    PlanePictures camera(truth, sensor, seed);
    const FlatPattern pattern = pattern_of(printed_board);
    const PrintedBoard board = pictures.flat ? PrintedBoard(printed_board) : glued_board(printed_board, random);
    std::vector<BoardShot> seen;
    LumaImage picture;
    for (const Eigen::Isometry3d& pose : board_poses(truth, printed_board.corner(printed_board.corners() - 1), pictures.shots, random)) {
        photograph(camera, pattern, shown(board, pictures.flat ? standing_still : in_a_hand, random), pose, seen.size(), picture);
        seen.push_back(find_chessboard(picture, printed_board, std::to_string(seen.size())));
    }
    return calibrate_lens(std::move(seen), truth.width, truth.height, printed_board, {.kind = truth.kind});
}

Result<KnownPose> photographed_floor(const ScenarioCamera& truth, const Scene& scene, const SiteCamera& known, double tile, std::uint64_t seed) {
    const auto* clicked = std::get_if<KnownFloorPoints>(&known.placement);
    if (clicked == nullptr) return Error{fmt::format("camera {} has no floor points", known.id)};
    FloorSource clicks{"clicked points"};
    for (const FloorPoint& p : clicked->points) clicks.sightings.push_back(clicked_point(p.pixel, p.map, clicked->sigma));
    const auto first = calibrate_floor(known.model, known.intrinsics_covariance, {clicks});
    if (!first) return first.error();
    LumaImage picture;
    CameraRenderer(scene, truth.truth, truth.sensor, seed).render({}, 1, 0, picture);
    UncertainPose3 start;
    const FloorSource joints = find_tile_grid_from_either(picture, known.model, *first, {{}, tile}, {clicks}, start);
    const auto found = calibrate_floor(known.model, known.intrinsics_covariance, {clicks, joints}, start);
    if (!found) return found.error();
    return KnownPose{found->map_from_camera, true, found->by_intrinsics};
}

Result<MountCalibration> photographed_mount(const Scenario& scenario, const CameraModel& model, const IntrinsicsErrors& intrinsics,
                                            const MountSettings& settings, std::uint64_t seed) {
    const ScenarioUpCamera& truth = scenario.up_cameras[0];
    const ScenarioRobot& robot = scenario.robots[truth.robot];
    const auto& mount = std::get<Mount>(scenario.site.cameras[0].placement);
    const CameraOnRobot camera{model, mount.robot_from_camera, intrinsics};
    CeilingRenderer renderer(truth.truth.model, truth.sensor, truth.glare, seed);
    CeilingObserver observer(camera, false, scenario.site.landmarks);
    RobotLocator locator(scenario.site, 0, camera);
    Random random(seed * 4099 + 5);
    const bool drives = robot.robot.odometry.has_value();
    const int count = drives ? static_cast<int>(scenario.duration / frame_interval) : spin_frames;
    CeilingResult seen;
    LocatedRobot located;
    LumaImage picture;
    std::vector<MountFrame> frames;
    for (int i = 0; i < count; ++i) {
        const double time = i * frame_interval;
        Pose2 pose = robot_pose(robot, time);
        if (!drives) pose = {pose.x + random.normal(spot_wobble), pose.y + random.normal(spot_wobble), 2 * std::numbers::pi * i / count};
        renderer.render(scenario.ceiling, map_from_robot(pose) * truth.truth.robot_from_camera.pose, light_at(time, 3), static_cast<std::uint64_t>(i), picture);
        observer.observe(picture, seen);
        locator.locate(seen.landmarks, {}, {}, located);
        if (located.places.empty()) continue;
        frames.push_back({locator.seen_points(seen.landmarks, located.places[0]), located.places[0].pose, from_seconds(time)});
    }
    OdometryTrack wheels;
    if (drives) {
        for (const WheelPose& w : wheels_of(scenario, truth.robot, seed).until(scenario.duration)) wheels.add(from_seconds(w.time), w.pose);
    }
    return calibrate_mount(camera, std::move(frames), settings, wheels);
}

std::vector<MountFrame> seen_turn(const CameraOnRobot& truth, double range, int count, double noise, double wobble, Random& random) {
    const Scenario scenario = kim2011_spin_scenario(1, 0);
    const auto leds = map_points(scenario.site.landmarks[0]);
    const Eigen::Vector2d& spot = scenario.robots[0].path[0];
    std::vector<MountFrame> frames;
    for (int i = 0; i < count; ++i) {
        const Pose2 pose{spot.x() + random.normal(wobble), spot.y() + random.normal(wobble), wrap_angle(range * i / count)};
        if (auto frame = seen_from(truth, pose, leds, noise, random)) frames.push_back(std::move(*frame));
    }
    return frames;
}

SeenDrive seen_drive(const CameraOnRobot& truth, double noise, std::uint64_t seed) {
    const Scenario scenario = kim2011_drive_scenario(seed, 0);
    const auto leds = map_points(scenario.site.landmarks[0]);
    Random random(seed * 31 + 7);
    SeenDrive drive;
    for (double time = 0; time < scenario.duration; time += frame_interval) {
        auto frame = seen_from(truth, robot_pose(scenario.robots[0], time), leds, noise, random);
        if (!frame) continue;
        frame->time = from_seconds(time);
        drive.frames.push_back(std::move(*frame));
    }
    for (const WheelPose& w : wheels_of(scenario, 0, seed).until(scenario.duration)) drive.wheels.add(from_seconds(w.time), w.pose);
    return drive;
}

}  // namespace roomfix
