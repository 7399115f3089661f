// What a camera on a robot says about one landmark at one time.
#pragma once

#include <Eigen/Core>

#include "roomfix/base/fixed_list.hpp"
#include "roomfix/observation/time_error.hpp"

namespace roomfix {

/// One point of a landmark in the picture.
struct PointSighting {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();           // px
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  // px^2
};

/// Which landmark it is may be open: all landmarks of a shape look alike.
struct LandmarkObservation {
    FixedList<PointSighting, 4> points;  // in the order of own_points()
    FixedList<int, 4> shapes;            // that it may have, indices of landmark_shapes()
    TimeError time_error;
};

}  // namespace roomfix
