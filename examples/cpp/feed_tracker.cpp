// Feeds the tracker by hand: a robot drives through a room with four beacons and tells its ranges and its odometry.
#include <fmt/format.h>

#include <cmath>
#include <roomfix/pipeline/site_tracker.hpp>
#include <string>

namespace {

/// 8 x 6 m, a beacon in each upper corner, one robot with a receiver and wheels.
roomfix::Site room() {
    roomfix::Site site;
    const double corners[4][2] = {{0, 0}, {8, 0}, {8, 6}, {0, 6}};
    for (const auto& corner : corners) {
        roomfix::SiteBeacon beacon;
        beacon.id = "b" + std::to_string(site.beacons.size() + 1);
        beacon.position = {corner[0], corner[1], 2.5};
        site.beacons.push_back(beacon);
    }
    roomfix::SiteRobot robot;
    robot.id = "r1";
    robot.shape = roomfix::Box{0.5, 0.4, 0.4};
    roomfix::Receiver receiver;
    receiver.position = {0, 0, 0.5};
    robot.receivers.push_back(receiver);
    robot.odometry.emplace();
    site.robots.push_back(robot);
    return site;
}

}  // namespace

int main() {
    const auto tracker = roomfix::SiteTracker::create(room());
    if (!tracker) {
        fmt::print(stderr, "{}\n", tracker.error().message);
        return 1;
    }
    (*tracker)->on_fixes([](const roomfix::FixBatch& batch) {
        for (const roomfix::Fix& fix : batch.given) {
            if (fix.status != roomfix::FixStatus::ok) continue;
            fmt::print("{:.2f} s: {} at {:.3f} {:.3f} m, one sigma {:.3f} m\n", roomfix::to_seconds(fix.time), fix.robot, fix.pose.x, fix.pose.y,
                       std::sqrt(fix.covariance.topLeftCorner<2, 2>().trace()));
        }
    });
    // A circle of 1.5 m radius, 0.3 rad/s; one range every 0.1 s, and odometry with each.
    for (int i = 0; i < 300; ++i) {
        const roomfix::Nanoseconds time = 1'000'000'000LL + i * 100'000'000LL;
        const double angle = 0.03 * i;
        const roomfix::Pose2 pose{4 + 1.5 * std::cos(angle), 3 + 1.5 * std::sin(angle), angle + 1.5707963};
        roomfix::OdometryBatch driven;
        driven.poses.push_back({time, 0, pose});
        (*tracker)->process(driven);
        const int beacon = i % 4;
        const Eigen::Vector3d receiver(pose.x, pose.y, 0.5);
        roomfix::RangeBatch heard;
        heard.ranges.push_back({time, 0, beacon, ((*tracker)->site().beacons[static_cast<std::size_t>(beacon)].position - receiver).norm(), 0.02});
        (*tracker)->process(heard);
    }
}
