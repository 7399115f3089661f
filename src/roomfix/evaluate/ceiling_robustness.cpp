#include "roomfix/evaluate/ceiling_robustness.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "roomfix/base/random_vector.hpp"
#include "roomfix/ceiling/ceiling_observer.hpp"
#include "roomfix/ceiling/robot_locator.hpp"
#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {
namespace {

/// Lamps and small lights around the robot: up to two tubes, up to three downlights, up to four LEDs that belong to other things.
void add_lights(const Eigen::Vector2d& around, Random& random, CeilingScene& scene) {
    const int tubes = 1 + random.index(2);
    for (int i = 0; i < tubes; ++i) scene.patches.insert(scene.patches.begin(), random_tube(around, 1.6, random));
    const auto place = [&]() -> Eigen::Vector2d { return around + uniform2(random, {-1.6, -1.4}, {1.6, 1.4}); };
    for (int i = random.index(4); i > 0; --i) scene.discs.push_back({place(), random.uniform(0.02, 0.08), static_cast<float>(random.uniform(3, 20))});
    for (int i = random.index(5); i > 0; --i) scene.discs.push_back({place(), random.uniform(0.0015, 0.004), static_cast<float>(random.uniform(5, 60))});
}

/// Nothing else may lie over the panel: what covers a LED makes it dead.
bool covers_panel(const CeilingScene& scene, const Eigen::Vector2d& landmark) {
    constexpr double reach = 0.16;
    for (const CeilingDisc& disc : scene.discs) {
        const double distance = (disc.centre - landmark).norm();
        const bool led = disc.radius == LandmarkLook().led_radius && disc.light == LandmarkLook().led_light;
        if (!led && distance < reach + disc.radius) return true;
    }
    return false;
}

CeilingRobustness run(int frames, std::uint64_t seed, bool with_landmark, const std::function<void(double)>& progress) {
    const Scenario scenario = kim2011_scenario(seed);
    const auto& mount = std::get<Mount>(scenario.site.cameras[0].placement);
    const CameraOnRobot camera{scenario.site.cameras[0].model, mount.robot_from_camera};
    const SiteLandmark& landmark = scenario.site.landmarks[0];
    const Eigen::Vector2d place = landmark.map_from_landmark.translation().head<2>();
    const ScenarioUpCamera& up = scenario.up_cameras[0];
    CeilingRenderer renderer(up.truth.model, up.sensor, up.glare, seed);
    CeilingObserver observer(camera, true, scenario.site.landmarks);
    RobotLocator locator(scenario.site, 0, camera);
    Random random(seed ^ 0x1a3b);
    CeilingResult seen;
    LocatedRobot located;
    LumaImage frame;
    CeilingRobustness result;
    while (result.frames < frames) {
        CeilingScene scene;
        scene.height = scenario.ceiling.height;
        scene.seed = random.bits();
        scene.tile_light = static_cast<float>(random.uniform(0.01, 0.35));
        scene.rail_light = scene.tile_light * static_cast<float>(random.uniform(0.6, 1.6));
        const Pose2 truth{place.x() + random.uniform(-0.9, 0.9), place.y() + random.uniform(-0.9, 0.9), random.uniform(-std::numbers::pi, std::numbers::pi)};
        if (with_landmark) {
            const bool inside = [&] {
                for (const Eigen::Vector3d& led : map_points(landmark)) {
                    const auto pixel = predict_point(camera, truth, led);
                    if (!pixel || !camera.model.contains(*pixel, 8)) return false;
                }
                return true;
            }();
            if (!inside) continue;
            add_landmark(landmark, {}, scene);
        }
        add_lights({truth.x, truth.y}, random, scene);
        if (with_landmark && random.index(2) == 0) scene.patches.push_back(tube_at_panel(landmark, {}, random));
        if (with_landmark && covers_panel(scene, place)) continue;
        renderer.render(scene, map_from_robot(truth) * up.truth.robot_from_camera.pose, 1, static_cast<std::uint64_t>(result.frames), frame);
        observer.observe(frame, seen);
        locator.locate(seen.landmarks, {}, {}, located);
        ++result.frames;
        bool right = false;
        if (located.places.empty()) {
            ++result.none;
        } else {
            const Eigen::Vector3d error = pose_error(located.places[0].pose, truth, 2 * std::numbers::pi);
            right = with_landmark && error.head<2>().norm() < 0.01 && std::abs(error.z()) < radians(1);
            ++(right ? result.right : result.wrong);
        }
        if (!right && with_landmark && result.first_miss.empty()) {
            result.first_miss = fmt::format("seed {}, frame {}: {}", seed, result.frames - 1, located.places.empty() ? seen.reason : "wrong");
        }
        if (progress) progress(static_cast<double>(result.frames) / frames);
    }
    return result;
}

}  // namespace

CeilingRobustness run_with_lamps(int frames, std::uint64_t seed, const std::function<void(double)>& progress) { return run(frames, seed, true, progress); }

CeilingRobustness run_without_landmark(int frames, std::uint64_t seed, const std::function<void(double)>& progress) {
    return run(frames, seed, false, progress);
}

}  // namespace roomfix
