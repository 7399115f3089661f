#include "roomfix/calibrate/mount.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "roomfix/base/random.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {
namespace {

/// What a robot would see that turns on the spot, straight from geometry; each frame's pose is a rough guess.
std::vector<MountFrame> turn(const CameraOnRobot& truth, double range, int count, double noise, double wobble, Random& random) {
    const Scenario scenario = kim2011_spin_scenario(1, 0);
    const auto leds = map_points(scenario.site.landmarks[0]);
    std::vector<MountFrame> frames;
    for (int i = 0; i < count; ++i) {
        const Pose2 pose{1.35 + random.normal(wobble), 1.05 + random.normal(wobble), wrap_angle(range * i / count)};
        MountFrame frame;
        frame.pose = {pose.x + random.normal(0.02), pose.y + random.normal(0.02), pose.yaw + random.normal(0.02)};
        for (const auto& led : leds) {
            const Eigen::Vector2d pixel = *predict_point(truth, pose, led);
            frame.points.push_back(
                {led, pixel + Eigen::Vector2d(random.normal(noise), random.normal(noise)), noise * noise * Eigen::Matrix2d::Identity(), 0, 0});
        }
        frames.push_back(frame);
    }
    return frames;
}

CameraOnRobot level() { return {kim2011_spin_scenario(1, 0).site.cameras[0].model, {looking_up(0.30), Matrix6d::Zero()}}; }

TEST(CalibrateMount, FindsTheTiltAndItsCovarianceIsTrue) {
    // Six unknowns, of which the heading keeps its prior (no error here): 5 seen ones over 60 runs, 5 +- 1.6 is a false alarm in 1e-4.
    Random random(3);
    double sum = 0;
    constexpr int runs = 60;
    const MountSettings settings{.point_sigma = 1e-6};
    for (int i = 0; i < runs; ++i) {
        CameraOnRobot truth = level();
        Vector6d error = Vector6d::Zero();
        for (int k = 0; k < 3; ++k) error[k] = random.normal(settings.position_sigma);
        error[3] = random.normal(radians(0.5));
        error[4] = random.normal(radians(0.5));
        truth.robot_from_camera.pose = perturbed(truth.robot_from_camera.pose, error);
        const auto found = calibrate_mount(level(), turn(truth, 2 * std::numbers::pi, 60, 0.02, 0.002, random), settings);
        ASSERT_TRUE(found) << found.error().message;
        Vector6d off;
        const Eigen::AngleAxisd rest(found->robot_from_camera.pose.linear() * truth.robot_from_camera.pose.linear().transpose());
        off << found->robot_from_camera.pose.translation() - truth.robot_from_camera.pose.translation(), rest.angle() * rest.axis();
        const Eigen::Matrix<double, 5, 5> p = found->robot_from_camera.covariance.topLeftCorner<5, 5>();
        sum += off.head<5>().dot(p.inverse() * off.head<5>());
        EXPECT_EQ(found->not_observed.size(), 1U) << "a turn on the spot does not show the camera's own heading";
    }
    EXPECT_NEAR(sum / runs, 5, 1.6);
}

TEST(CalibrateMount, SaysWhatIsMissing) {
    Random random(4);
    const auto few = calibrate_mount(level(), turn(level(), 2 * std::numbers::pi, 5, 0.02, 0, random));
    ASSERT_FALSE(few);
    EXPECT_NE(few.error().message.find("8 are needed"), std::string::npos);
    const auto quarter = calibrate_mount(level(), turn(level(), std::numbers::pi / 2, 40, 0.02, 0, random));
    ASSERT_FALSE(quarter);
    EXPECT_NE(quarter.error().message.find("full turn"), std::string::npos);
    EXPECT_FALSE(calibrate_mount(level(), {}));
}

}  // namespace
}  // namespace roomfix
