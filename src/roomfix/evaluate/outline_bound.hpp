// The Cramer-Rao bound for a robot's pose from its outline in one picture.
#pragma once

#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/background_model.hpp"
#include "roomfix/overhead/silhouette.hpp"
#include "roomfix/simulate/camera_renderer.hpp"

namespace roomfix {

/// The smallest covariance of x, y, yaw (m, rad) that any unbiased estimator can reach from the outline's pixels, and with
/// the calibration's covariance of `true_view` added. Each pixel along the outline is one blurred step edge in noise, whose
/// place is known to sigma^2 = 2 sqrt(pi) blur noise^2 / contrast^2 at best; contrast is taken from the frame itself at the
/// true outline. `truth` is the true pose; `true_view` is the true camera with the uncertainty that its calibration has.
struct OutlineBound {
    Eigen::Matrix3d pixels = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d with_calibration = Eigen::Matrix3d::Zero();
};
OutlineBound outline_bound(LumaView frame, LumaView background, const View& true_view, const ShapePoints& shape, const Pose2& truth, const SensorModel& sensor);

}  // namespace roomfix
