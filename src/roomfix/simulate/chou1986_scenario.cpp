#include <algorithm>
#include <cmath>

#include "roomfix/simulate/room_shots.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {

Scenario chou1986_scenario(std::uint64_t seed, bool cluttered) {
    Scenario scenario;
    scenario.name = scenario.site.name = cluttered ? "chou1986-cluttered" : "chou1986";
    Random random(seed ^ 0xc0071986);
    // One room; the camera is carried to 16 places, six looks at each.
    const RoomShot first = cluttered ? cluttered_shot(random) : chou1986_shot(chou1986_places()[0], random);
    scenario.room = first.scene;
    ScenarioEye eye{"eye", 0, {room_camera(), {}}, room_sensor(), {}, {}};
    for (const Eigen::Vector2d& place : chou1986_places()) {
        for (int i = 0; i < chou1986_pictures; ++i) eye.stops.push_back(look_at_corner(place, first.corner.position, random));
    }
    Site& site = scenario.site;
    site.ceiling = first.scene.height;
    site.walls = {first.scene.walls};
    site.walls[0].push_back(first.scene.walls[0]);
    // The corner defines the map here; on a real ceiling its height limits the fix.
    SiteCorner corner = first.corner;
    corner.sigma = 0;
    site.corners = {corner};
    site.cameras = {{"eye", "frames/eye", eye.truth.model, KnownHeight{chou1986_camera_height, 1e-4, "tripod"}, ""}};
    const SiteRobot tripod{"tripod", Cylinder{0.4, chou1986_camera_height}};
    site.robots = {tripod};
    scenario.robots = {{tripod, {}, {}, 0, 0, 0}};
    scenario.frame_rate = 1;
    scenario.duration = static_cast<double>(eye.stops.size());
    scenario.eyes = {eye};
    return scenario;
}

Eigen::Isometry3d eye_pose(const Scenario& scenario, const ScenarioEye& eye, double time) {
    if (eye.stops.empty()) return map_from_robot(robot_pose(scenario.robots[eye.robot], time)) * eye.truth.robot_from_camera.pose;
    const auto index = static_cast<std::size_t>(std::max(0L, std::lround(time * scenario.frame_rate)));
    return eye.stops[std::min(index, eye.stops.size() - 1)];
}

Pose2 true_pose(const Scenario& scenario, std::size_t robot, double time) {
    for (const ScenarioEye& eye : scenario.eyes) {
        if (eye.robot != robot || eye.stops.empty()) continue;
        const Eigen::Isometry3d pose = eye_pose(scenario, eye, time);
        const Eigen::Vector3d axis = pose.linear().col(2);
        return {pose.translation().x(), pose.translation().y(), std::atan2(axis.y(), axis.x())};
    }
    return robot_pose(scenario.robots[robot], time);
}

}  // namespace roomfix
