// How far a pose may be off that was only reckoned from the way and the turns since the start.
#pragma once

#include <Eigen/Core>

#include "roomfix/observation/odometry_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

class DeadReckoningError {
public:
    explicit DeadReckoningError(const WheelOdometry& wheels) : wheels_(wheels) {}

    /// The next report of the same robot, in the order of their times.
    void go_on(const OdometryObservation& report);
    /// Of the newest pose in the frame `odom`: x, y, yaw; m, rad. It grows with the way, the turns and the time.
    Eigen::Matrix3d covariance() const;

private:
    WheelOdometry wheels_;
    OdometryObservation first_, last_;
    bool started_ = false;
    double way_ = 0;     // m
    double turned_ = 0;  // rad, in both directions
};

}  // namespace roomfix
