#include "roomfix/pipeline/dead_reckoning_error.hpp"

#include <cmath>

namespace roomfix {

void DeadReckoningError::go_on(const OdometryObservation& report) {
    if (!started_) first_ = last_ = report;
    started_ = true;
    way_ += std::hypot(report.pose.x - last_.pose.x, report.pose.y - last_.pose.y);
    turned_ += std::abs(wrap_angle(report.pose.yaw - last_.pose.yaw));
    last_ = report;
}

Eigen::Matrix3d DeadReckoningError::covariance() const {
    constexpr double smallest = 1e-6;  // m^2, rad^2: what reports are rounded to
    const double seconds = to_seconds(last_.time - first_.time);
    const double by_turns = wheels_.turn_scale_sigma * turned_, by_drift = wheels_.drift_sigma * seconds;
    const double yaw = by_turns * by_turns + by_drift * by_drift;
    const double place = way_ * way_ * (wheels_.scale_sigma * wheels_.scale_sigma + yaw);
    return Eigen::Vector3d(place + smallest, place + smallest, yaw + smallest).asDiagonal();
}

}  // namespace roomfix
