#include "roomfix/calibrate/mount.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/evaluate/simulated_calibration.hpp"

namespace roomfix {
namespace {

CameraOnRobot level() { return {kim2011_spin_scenario(1, 0).site.cameras[0].model, {looking_up(0.30), Matrix6d::Zero()}}; }

/// A camera that was placed by tape, about level.
CameraOnRobot carelessly_mounted(const MountSettings& settings, double heading_sigma, Random& random) {
    CameraOnRobot camera = level();
    Vector6d error = Vector6d::Zero();
    for (int k = 0; k < 3; ++k) error[k] = random.normal(settings.position_sigma);
    error[3] = random.normal(radians(0.5));
    error[4] = random.normal(radians(0.5));
    if (heading_sigma > 0) error[5] = random.normal(heading_sigma);
    camera.robot_from_camera.pose = perturbed(camera.robot_from_camera.pose, error);
    return camera;
}

TEST(CalibrateMount, FindsTheTiltAndItsCovarianceIsTrue) {
    // Six unknowns, of which the heading keeps its prior (no error here): 5 seen ones over 60 runs, 5 +- 1.6 is a false alarm in 1e-4.
    Random random(3);
    double sum = 0;
    constexpr int runs = 60;
    const MountSettings settings{.point_sigma = 1e-6};
    for (int i = 0; i < runs; ++i) {
        const CameraOnRobot truth = carelessly_mounted(settings, 0, random);
        const auto found = calibrate_mount(level(), seen_turn(truth, 2 * std::numbers::pi, 60, 0.02, 0.002, random), settings);
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

TEST(CalibrateMount, ADriveShowsTheHeadingToo) {
    // Six unknowns over 40 runs, 6 +- 2.1 is a false alarm in 1e-4; wheels are simulated a little better than they are taken for.
    Random random(8);
    double sum = 0;
    constexpr int runs = 40;
    const MountSettings settings{.point_sigma = 1e-6};
    for (int i = 0; i < runs; ++i) {
        const CameraOnRobot truth = carelessly_mounted(settings, settings.heading_sigma, random);
        const SeenDrive drive = seen_drive(truth, 0.02, 300 + static_cast<std::uint64_t>(i));
        const auto found = calibrate_mount(level(), drive.frames, settings, drive.wheels);
        ASSERT_TRUE(found) << found.error().message;
        EXPECT_TRUE(found->with_wheels);
        EXPECT_TRUE(found->not_observed.empty()) << found->not_observed[0];
        const Vector6d off = error_between(truth.robot_from_camera.pose, found->robot_from_camera.pose);
        sum += off.dot(found->robot_from_camera.covariance.inverse() * off);
    }
    EXPECT_GT(sum / runs, 3.5);
    EXPECT_LT(sum / runs, 8.1);
}

TEST(CalibrateMount, AFrameThatShowsAnotherLandmarkIsLeftOut) {
    Random random(9);
    auto frames = seen_turn(level(), 2 * std::numbers::pi, 60, 0.02, 0.002, random);
    frames[7].points[1].pixel += Eigen::Vector2d(3, -2);
    const auto found = calibrate_mount(level(), frames);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->refused, 1);
    EXPECT_LT(found->tilt, 4 * found->tilt_sigma);
}

TEST(CalibrateMount, MovesWithTheIntrinsicsAsItSays) {
    Random random(10);
    CameraOnRobot known = level();
    known.intrinsics.covariance.diagonal().head<4>().setConstant(0.04);
    const auto frames = seen_turn(level(), 2 * std::numbers::pi, 60, 0.02, 0.002, random);
    const auto before = calibrate_mount(known, frames);
    IntrinsicsVector numbers = known.model.intrinsics();
    numbers[2] += 0.3;
    numbers[3] -= 0.2;
    known.model.set_intrinsics(numbers);
    const auto after = calibrate_mount(known, frames);
    ASSERT_TRUE(before && after);
    const Vector6d moved = error_between(before->robot_from_camera.pose, after->robot_from_camera.pose);
    const Vector6d predicted = before->by_intrinsics.col(2) * 0.3 - before->by_intrinsics.col(3) * 0.2;
    EXPECT_GT(moved.head<3>().norm(), 0.001) << "m";
    EXPECT_LT((moved - predicted).head<3>().norm(), 0.05 * moved.head<3>().norm());
    EXPECT_LT((moved - predicted).segment<2>(3).norm(), 0.05 * moved.tail<3>().norm());
}

TEST(CalibrateMount, SaysWhatIsMissing) {
    Random random(4);
    const auto few = calibrate_mount(level(), seen_turn(level(), 2 * std::numbers::pi, 5, 0.02, 0, random));
    ASSERT_FALSE(few);
    EXPECT_NE(few.error().message.find("8 are needed"), std::string::npos);
    const auto quarter = calibrate_mount(level(), seen_turn(level(), std::numbers::pi / 2, 40, 0.02, 0, random));
    ASSERT_FALSE(quarter);
    EXPECT_NE(quarter.error().message.find("full turn"), std::string::npos);
    EXPECT_FALSE(calibrate_mount(level(), {}));
    const auto driven = calibrate_mount(level(), seen_drive(level(), 0.02, 5).frames);
    ASSERT_FALSE(driven) << "without its wheels a drive cannot be used";
    EXPECT_NE(driven.error().message.find("odometry"), std::string::npos);
    auto still = seen_turn(level(), 0.01, 40, 0.02, 0, random);
    OdometryTrack wheels;
    for (std::size_t i = 0; i < still.size(); ++i) {
        still[i].time = from_seconds(0.2 * static_cast<double>(i));
        wheels.add(still[i].time, {});
    }
    const auto unmoved = calibrate_mount(level(), still, {}, wheels);
    ASSERT_FALSE(unmoved);
    EXPECT_NE(unmoved.error().message.find("hardly moved"), std::string::npos) << unmoved.error().message;
}

}  // namespace
}  // namespace roomfix
