#include "roomfix/simulate/scenario_renderer.hpp"

#include "roomfix/geometry/row_time.hpp"

namespace roomfix {
namespace {

using Renderer = std::variant<CameraRenderer, CeilingRenderer, RoomRenderer>;

Renderer renderer_of(const Scenario& scenario, std::size_t camera, std::uint64_t seed, double turned) {
    const std::size_t fixed = scenario.cameras.size(), ups = scenario.up_cameras.size();
    if (camera < fixed) {
        View view = scenario.cameras[camera].truth;
        view.map_from_camera.pose.linear() = exponential_rotation({0, 0, turned}) * view.map_from_camera.pose.linear();
        return CameraRenderer(scenario.scene, view, scenario.cameras[camera].sensor, seed * 31 + camera);
    }
    if (camera < fixed + ups) {
        const ScenarioUpCamera& up = scenario.up_cameras[camera - fixed];
        return CeilingRenderer(up.truth.model, up.sensor, up.glare, seed * 37 + camera - fixed);
    }
    const ScenarioEye& eye = scenario.eyes[camera - fixed - ups];
    return RoomRenderer(eye.truth.model, eye.sensor, eye.glare, seed * 41 + camera - fixed - ups);
}

}  // namespace

std::size_t camera_count(const Scenario& scenario) { return scenario.cameras.size() + scenario.up_cameras.size() + scenario.eyes.size(); }

const std::string& camera_id(const Scenario& scenario, std::size_t camera) {
    const std::size_t fixed = scenario.cameras.size(), ups = scenario.up_cameras.size();
    if (camera < fixed) return scenario.cameras[camera].id;
    return camera < fixed + ups ? scenario.up_cameras[camera - fixed].id : scenario.eyes[camera - fixed - ups].id;
}

ScenarioRenderer::ScenarioRenderer(const Scenario& scenario, std::size_t camera, std::uint64_t seed, double turned)
    : scenario_(scenario), number_(camera), seed_(seed), renderer_(renderer_of(scenario, camera, seed, turned)) {
    if (renderer_.index() > 0) number_ -= scenario.cameras.size();
    if (renderer_.index() > 1) number_ -= scenario.up_cameras.size();
}

/// What fixed cameras see move at a time.
std::vector<Solid> ScenarioRenderer::solids_at(double time) const {
    std::vector<Solid> solids;
    for (const auto* group : {&scenario_.robots, &scenario_.others}) {
        for (const ScenarioRobot& robot : *group) {
            if (time >= robot.until) continue;
            const Pose2 pose = robot_pose(robot, time);
            if (robot.solids.empty()) {
                const auto parts = robot_solids(robot.robot.shape, robot.look, pose);
                solids.insert(solids.end(), parts.begin(), parts.end());
            }
            for (const Solid& solid : robot.solids) solids.push_back(placed(solid, pose));
        }
    }
    return solids;
}

/// Where a camera on a robot is while the rows of its picture are exposed: one pose, or one of each row.
template <class PoseAt>
std::vector<Eigen::Isometry3d> poses_of_rows(double time, double readout, int rows, const PoseAt& pose_at) {
    if (!(readout > 0)) return {pose_at(time)};
    std::vector<Eigen::Isometry3d> poses;
    for (int row = 0; row < rows; ++row) poses.push_back(pose_at(time + row_time(readout, rows, row)));
    return poses;
}

void ScenarioRenderer::render(double time, std::uint64_t index, LumaImage& frame) {
    if (const auto* fixed = std::get_if<CameraRenderer>(&renderer_)) {
        const ScenarioCamera& camera = scenario_.cameras[number_];
        const double light = light_at(time, seed_ + number_);
        const double readout = camera.sensor.readout;
        if (!(readout > 0)) return fixed->render(solids_at(time), light, index, frame);
        const int rows = camera.truth.model.height;
        fixed->render_rows([&](double row) { return solids_at(time + row_time(readout, rows, row)); }, light, index, frame);
    } else if (auto* up = std::get_if<CeilingRenderer>(&renderer_)) {
        const ScenarioUpCamera& camera = scenario_.up_cameras[number_];
        const auto poses = poses_of_rows(time, camera.sensor.readout, camera.truth.model.height, [&](double at) -> Eigen::Isometry3d {
            return map_from_robot(robot_pose(scenario_.robots[camera.robot], at)) * camera.truth.robot_from_camera.pose;
        });
        up->render(scenario_.ceiling, RowPoses(poses), light_at(time, seed_ + 50 + number_), index, frame);
    } else {
        const ScenarioEye& eye = scenario_.eyes[number_];
        const double readout = eye.stops.empty() ? eye.sensor.readout : 0;  // a tripod stands still
        const auto poses = poses_of_rows(time, readout, eye.truth.model.height, [&](double at) { return eye_pose(scenario_, eye, at); });
        std::get<RoomRenderer>(renderer_).render(scenario_.room, RowPoses(poses), light_at(time, seed_ + 80 + number_), index, frame);
    }
}

void ScenarioRenderer::render_empty(std::uint64_t index, LumaImage& frame) {
    constexpr std::uint64_t empty_pictures = 1'000'000;  // their numbers: none of those with robots has the same noise
    std::get<CameraRenderer>(renderer_).render({}, light_at(-0.1 * static_cast<double>(index), seed_ + number_), empty_pictures + index, frame);
}

}  // namespace roomfix
