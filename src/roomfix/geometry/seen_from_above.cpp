#include "roomfix/geometry/seen_from_above.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {

PoseFromAbove seen_from_above(const UncertainPose3& map_from_camera) {
    constexpr double least_level = 1e-4;  // square of the axis' part along the floor
    const Eigen::Vector3d place = map_from_camera.pose.translation();
    const Eigen::Vector3d axis = map_from_camera.pose.linear().col(2);
    const double level = axis.head<2>().squaredNorm();
    Eigen::Matrix<double, 3, 6> by = Eigen::Matrix<double, 3, 6>::Zero();
    by(0, 0) = by(1, 1) = 1;
    by.row(2).tail<3>() << -axis.z() * axis.x() / std::max(level, least_level), -axis.z() * axis.y() / std::max(level, least_level), 1;
    return {{place.x(), place.y(), std::atan2(axis.y(), axis.x())}, level > least_level, by * map_from_camera.covariance * by.transpose()};
}

}  // namespace roomfix
