// How robots move between observations: by their momentum, or by what their wheels report.
#pragma once

#include "roomfix/estimate/belief.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// Accelerations are white noise: variance of the speed grows by acceleration^2 per second. Speeds die away over `memory` seconds.
struct MotionModel {
    Drive drive = Drive::unknown;
    double acceleration = 0.5;       // m/s per square root of a second
    double side_acceleration = 0.1;  // the same across the wheels of a differential drive
    double turning = 1.0;            // rad/s per square root of a second
    double memory = 10;              // s
    double slip_memory = 0.3;        // s, of the speed across the wheels of a differential drive
};

/// Predicts `seconds` >= 0 ahead from the velocity.
void predict(Belief& belief, double seconds, const MotionModel& model);

/// What the wheels report of a stretch of time.
struct OdometryStep {
    double seconds = 0;
    Eigen::Vector2d way = Eigen::Vector2d::Zero();       // m, in the robot's frame at the beginning
    double turned = 0;                                   // rad
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  // m/s, in the robot's frame at the end
    double turn_rate = 0;                                // rad/s
};

/// How wheels err for good.
struct WheelErrors {
    double scale = 0, turn_scale = 0;  // true way = (1 + scale) * measured way, the same of the turning
    double drift = 0;                  // rad/s
    double delay = 0;                  // s: the robot moves so much later than they say
    bool learned = false;              // otherwise all of it may be
};

/// Random errors grow with the square root of way, angle and time; scales and drift are states of the belief.
struct OdometryNoise {
    double along = 0.01;            // m per square root of a metre
    double across = 0.01;           // m per square root of a metre
    double turn_per_metre = 0.01;   // rad per square root of a metre
    double turn_per_radian = 0.02;  // rad per square root of a radian
    double still = 0.0005;          // m per square root of a second, also at rest
    double still_turn = 0.0005;     // rad per square root of a second
    double scale_walk = 1e-4;       // of both scales, per square root of a second
    double drift_walk = 1e-4;       // rad/s per square root of a second
    double velocity = 0.05;         // m/s, of the velocity that the last step shows
    double turn_rate = 0.05;        // rad/s
    double delay = 0;               // s: the robot moves so much later than its odometry says
};

/// Predicts over the step. The velocity becomes that of the odometry.
void predict(Belief& belief, const OdometryStep& step, const OdometryNoise& noise);

}  // namespace roomfix
