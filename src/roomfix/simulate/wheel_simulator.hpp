// Wheel odometry as a real robot gives it: a constant scale error, a drift of the heading, and noise that grows with the way.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "roomfix/base/time.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

struct WheelModel {
    double scale = 0.01;            // true way = (1 + scale) * measured way
    double drift = 0.005;           // rad/s, true turning = measured turning + drift * time
    double along = 0.01;            // m per square root of a metre
    double across = 0.005;          // m per square root of a metre
    double turn_per_metre = 0.01;   // rad per square root of a metre
    double turn_per_radian = 0.02;  // rad per square root of a radian
    double rate = 20;               // poses per second
};

struct WheelPose {
    double time = 0;  // s
    Pose2 pose;       // in the robot's own `odom` frame, which starts at its first pose
};

class WheelSimulator {
public:
    /// `true_pose`: of the robot at a time (s).
    WheelSimulator(const WheelModel& model, std::function<Pose2(double)> true_pose, std::uint64_t seed)
        : model_(model), true_pose_(std::move(true_pose)), seed_(seed) {}

    /// The poses reported from the last call, or from time 0, to before `time` (s).
    std::vector<WheelPose> until(double time);

private:
    WheelModel model_;
    std::function<Pose2(double)> true_pose_;
    std::uint64_t seed_;
    std::uint64_t next_ = 0;
    Pose2 reported_;
};

}  // namespace roomfix
