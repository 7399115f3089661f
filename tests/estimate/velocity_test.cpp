// Fixes say how robots drive and turn, and how sure that is: beside the truth of simulated drives.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/estimate/tracker.hpp"

namespace roomfix {
namespace {

/// How a robot that speeds up, slows down and turns both ways is at each moment.
struct TrueMoment {
    Pose2 pose;
    Eigen::Vector3d velocity;  // in the map
};
constexpr double fine = 0.005;  // s between moments

std::vector<TrueMoment> wavy_drive(double seconds, double phase) {
    std::vector<TrueMoment> drive;
    Pose2 pose{2, 2, phase};
    for (double t = 0; t < seconds; t += fine) {
        const double speed = 0.4 + 0.25 * std::sin(0.6 * t + phase), turn = 0.3 + 0.5 * std::sin(0.45 * t + 2 * phase);
        drive.push_back({pose, {speed * std::cos(pose.yaw), speed * std::sin(pose.yaw), turn}});
        pose.x += speed * std::cos(pose.yaw + 0.5 * turn * fine) * fine;
        pose.y += speed * std::sin(pose.yaw + 0.5 * turn * fine) * fine;
        pose.yaw += turn * fine;
    }
    return drive;
}

/// Wheels whose errors grow with the way and the angle; they are a little small.
class SmallWheels {
public:
    explicit SmallWheels(Random& random) : random_(random) {}
    Pose2 go(const Pose2& before, const Pose2& now) {
        const double way = std::hypot(now.x - before.x, now.y - before.y), turned = now.yaw - before.yaw;
        const double measured = 1.015 * way + random_.normal(0.01 * std::sqrt(way));
        const double turning = 0.99 * turned + random_.normal(0.02 * std::sqrt(std::abs(turned)));
        pose_ = {pose_.x + measured * std::cos(pose_.yaw + 0.5 * turning), pose_.y + measured * std::sin(pose_.yaw + 0.5 * turning), pose_.yaw + turning};
        return {pose_.x, pose_.y, wrap_angle(pose_.yaw)};
    }

private:
    Random& random_;
    Pose2 pose_;
};

/// The mean normalised squares of the errors of a drive's velocities, in the map and in the robot's own axes, per component (1 where they are as large as
/// they are said to be), and of how many fixes.
struct Judged {
    double in_map = 0, in_robot = 0, speed_error = 0;  // ... and m/s, root of the mean square
    int fixes = 0, without = 0;
};

struct Senses {
    bool wheels = true;        // 20 times a second
    double camera_until = 40;  // s; 10 times a second
    double from = 5;           // s: fixes are judged from here on
    Drive drive = Drive::differential;
};

void judge(const Fix& fix, const TrueMoment& truth, Judged& judged) {
    if (!fix.velocity) {
        ++judged.without;
        return;
    }
    const Eigen::Vector3d off = *fix.velocity - truth.velocity;
    judged.in_map += off.dot(fix.velocity_covariance.llt().solve(off)) / 3;
    judged.speed_error += off.head<2>().squaredNorm();
    ++judged.fixes;
    // As odometry states it: the yaw's error beside the velocity's, as though they had nothing to do with each other.
    const auto own = [](const Pose2& pose) { return Eigen::AngleAxisd(-pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(); };
    const Eigen::Vector3d v = own(fix.pose) * *fix.velocity, by_yaw(v.y(), -v.x(), 0);
    const Eigen::Matrix3d covariance = own(fix.pose) * fix.velocity_covariance * own(fix.pose).transpose() + fix.covariance(2, 2) * by_yaw * by_yaw.transpose();
    const Eigen::Vector3d own_off = v - own(truth.pose) * truth.velocity;
    judged.in_robot += own_off.dot(covariance.llt().solve(own_off)) / 3;
}

Judged judged_drives(const Senses& senses, int drives) {
    constexpr double seconds = 40, camera_sigma = 0.01;
    Judged judged;
    for (int seed = 1; seed <= drives; ++seed) {
        Random random(static_cast<std::uint64_t>(seed));
        Site site;
        site.robots.resize(1);
        site.robots[0].id = "r1";
        site.robots[0].shape = Box{0.5, 0.4, 0.4};
        site.robots[0].drive = senses.drive;
        if (senses.wheels) site.robots[0].odometry = WheelOdometry{};
        Tracker tracker(site);
        SmallWheels wheels(random);
        const std::vector<TrueMoment> drive = wavy_drive(seconds, 0.7 * seed);
        constexpr int report = 10;  // moments between two reports of the wheels
        for (std::size_t i = report; i < drive.size(); i += report) {
            const Nanoseconds time = from_seconds(static_cast<double>(i) * fine);
            const Pose2& pose = drive[i].pose;
            if (senses.wheels) tracker.observe({time, 0, wheels.go(drive[i - report].pose, pose)});
            if (i % (2 * report) == 0 && to_seconds(time) < senses.camera_until) {
                PoseObservation seen;
                seen.pose = {pose.x + random.normal(camera_sigma), pose.y + random.normal(camera_sigma), wrap_angle(pose.yaw + random.normal(0.02))};
                seen.covariance = Eigen::Vector3d(camera_sigma * camera_sigma, camera_sigma * camera_sigma, 0.02 * 0.02).asDiagonal();
                tracker.observe(time, "hall", {&seen, 1});
            }
            const auto fix = tracker.fix(0, time);
            if (to_seconds(time) >= senses.from && fix && fix->status != FixStatus::none) judge(*fix, drive[i], judged);
        }
    }
    judged.in_map /= judged.fixes;
    judged.in_robot /= judged.fixes;
    judged.speed_error = std::sqrt(judged.speed_error / judged.fixes);
    return judged;
}

void print(const char* what, const Judged& judged) {
    fmt::print("velocity {}: {} fixes ({} without), error {:.3f} m/s, normalised squares per component {:.2f} in the map, {:.2f} in the robot's axes\n", what,
               judged.fixes, judged.without, judged.speed_error, judged.in_map, judged.in_robot);
}

/// Errors of velocities last: fixes of one drive say much the same. Hence no limits of chi squared, but 2 and a quarter.
void expect_true(const Judged& judged) {
    EXPECT_LT(judged.in_map, 2);
    EXPECT_GT(judged.in_map, 0.05);
    EXPECT_LT(judged.in_robot, 2);
    EXPECT_GT(judged.in_robot, 0.05);
}

TEST(Velocity, IsAsTrueAsItSaysByCameraAndWheels) {
    const Judged judged = judged_drives({}, 6);
    print("by camera and wheels", judged);
    expect_true(judged);
    EXPECT_EQ(judged.without, 0);
    EXPECT_LT(judged.speed_error, 0.06);
}

TEST(Velocity, IsAsTrueAsItSaysByTheCameraAlone) {
    for (const Drive drive : {Drive::differential, Drive::unknown}) {
        const Judged judged = judged_drives({.wheels = false, .drive = drive}, 6);
        print(drive == Drive::unknown ? "by the camera alone" : "by the camera alone, of two wheels", judged);
        expect_true(judged);
        EXPECT_EQ(judged.without, 0);
        EXPECT_LT(judged.speed_error, 0.15);
    }
}

TEST(Velocity, IsTrueWhileItCoastsByItsWheels) {
    const Judged judged = judged_drives({.camera_until = 20, .from = 21}, 6);
    print("by its wheels alone, 1 to 20 s after the camera's last word", judged);
    expect_true(judged);
    EXPECT_GT(judged.fixes, 1000);
}

TEST(Velocity, OfARobotSeenOnceIsNotStated) {
    Site site;
    site.robots.resize(1);
    site.robots[0].id = "r1";
    site.robots[0].shape = Box{0.5, 0.4, 0.4};
    Tracker tracker(site);
    PoseObservation seen;
    seen.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    tracker.observe(from_seconds(1), "hall", {&seen, 1});
    const auto fix = tracker.fix(0, from_seconds(1));
    ASSERT_TRUE(fix);
    EXPECT_EQ(fix->status, FixStatus::ok);
    EXPECT_FALSE(fix->velocity);
}

}  // namespace
}  // namespace roomfix
