#include "roomfix/evaluate/landmark_bound.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

constexpr int window = 6;  // px around a LED

/// Light of a picture, of its LEDs alone, and the derivatives of that by x, y and yaw.
struct LightField {
    int width, height;
    const std::vector<float>& all;
    const std::vector<float>& own;
    const std::array<std::vector<float>, 3>& slopes;
};

/// What one LED's pixels tell about the pose once its brightness and the ground around it are estimated with it.
Eigen::Matrix3d spot_information(const LightField& field, const Eigen::Vector2d& middle, const SensorModel& sensor) {
    Eigen::Matrix<double, 7, 7> information = Eigen::Matrix<double, 7, 7>::Zero();
    for (int y = static_cast<int>(middle.y()) - window; y <= static_cast<int>(middle.y()) + window + 1; ++y) {
        for (int x = static_cast<int>(middle.x()) - window; x <= static_cast<int>(middle.x()) + window + 1; ++x) {
            if (x < 0 || y < 0 || x >= field.width || y >= field.height) continue;
            const auto p = static_cast<std::size_t>(y * field.width + x);
            const double part = static_cast<double>(field.all[p]) / 255;
            const double grey = 255 * std::pow(part, 1 / sensor.gamma);
            if (part <= 0 || grey >= 254.5) continue;
            const double by_light = grey / (sensor.gamma * 255 * part);
            Eigen::Matrix<double, 7, 1> d;
            d << by_light * static_cast<double>(field.slopes[0][p]), by_light * static_cast<double>(field.slopes[1][p]),
                by_light * static_cast<double>(field.slopes[2][p]), by_light * static_cast<double>(field.own[p]), 1, x - middle.x(), y - middle.y();
            const double noise = pixel_noise(sensor, grey);
            information += d * d.transpose() / (noise * noise + 1.0 / 12);
        }
    }
    const Eigen::Matrix<double, 3, 4> cross = information.topRightCorner<3, 4>();
    const Eigen::Matrix4d nuisance = information.bottomRightCorner<4, 4>() + 1e-9 * Eigen::Matrix4d::Identity();
    return information.topLeftCorner<3, 3>() - cross * nuisance.ldlt().solve(cross.transpose());
}

}  // namespace

Eigen::Matrix3d landmark_information(const CeilingScene& scene, const CameraOnRobot& camera, const SensorModel& sensor, const GlareModel& glare,
                                     const Pose2& truth) {
    SensorModel linear = sensor;
    linear.gamma = 1;
    CeilingRenderer renderer(camera.model, linear, glare, 1);
    CeilingScene leds = scene;  // only these carry information: nobody knows where tiles and lamps are
    leds.patches.clear();
    leds.tile_light = leds.rail_light = 0;
    const auto light = [&](const CeilingScene& what, const Pose2& pose) {
        return renderer.expose(what, map_from_robot(pose) * camera.robot_from_camera.pose, 1);
    };
    const std::vector<float> all = light(scene, truth);
    std::array<std::vector<float>, 3> slopes;
    const std::array<double, 3> steps = {5e-4, 5e-4, 2e-3};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto moved = [&](double by) { return Pose2{truth.x + (i == 0 ? by : 0), truth.y + (i == 1 ? by : 0), truth.yaw + (i == 2 ? by : 0)}; };
        slopes[i] = light(leds, moved(steps[i]));
        const std::vector<float> before = light(leds, moved(-steps[i]));
        for (std::size_t p = 0; p < before.size(); ++p) slopes[i][p] = (slopes[i][p] - before[p]) / static_cast<float>(2 * steps[i]);
    }
    const std::vector<float> own = light(leds, truth);
    const View view{camera.model, {map_from_robot(truth) * camera.robot_from_camera.pose, Matrix6d::Zero()}};
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    for (const CeilingDisc& led : scene.discs) {
        const auto middle = project_map_point(view, {led.centre.x(), led.centre.y(), scene.height});
        if (middle) information += spot_information({camera.model.width, camera.model.height, all, own, slopes}, *middle, sensor);
    }
    return information;
}

Eigen::Matrix3d range_information(const Eigen::Vector3d& beacon, const Eigen::Vector3d& receiver, double sigma, const Pose2& truth) {
    const Eigen::Isometry3d robot = map_from_robot(truth);
    const Eigen::Vector3d arm = robot.linear() * receiver;
    const Eigen::Vector3d along = (robot.translation() + arm - beacon).normalized();
    const Eigen::Vector3d slope(along.x(), along.y(), along.dot(Eigen::Vector3d::UnitZ().cross(arm)));
    return slope * slope.transpose() / (sigma * sigma);
}

}  // namespace roomfix
