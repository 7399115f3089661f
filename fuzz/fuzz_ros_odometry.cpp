// Any bytes as messages that come over DDS: nav_msgs/msg/Odometry and ros_discovery_info.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "roomfix/connect/ros_graph.hpp"
#include "roomfix/connect/ros_odometry.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace roomfix;
    const std::span message(data, size);
    RosOdometry wheels(1);
    for (int i = 0; i < 2; ++i) {
        const OdometryBatch batch = wheels.read(message, from_seconds(1000 + i), 10.0 + i);
        for (const OdometryObservation& report : batch.poses) {
            if (report.robot != 1 || !std::isfinite(report.pose.x + report.pose.y + report.pose.yaw)) __builtin_trap();
        }
        if (batch.poses.size() + batch.problems.size() > 1) __builtin_trap();
    }
    (void)wheels.told();
    (void)ros::layout_of_graph(message);
    // What is understood is written as it stands.
    if (const auto odometry = ros::decode_odometry(message)) {
        const auto again = ros::decode_odometry(ros::encode(*odometry));
        if (!again || again->header.stamp != odometry->header.stamp || again->header.frame_id != odometry->header.frame_id) __builtin_trap();
    }
    return 0;
}
