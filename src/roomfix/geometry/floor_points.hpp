// A fixed camera's pose from points on the floor whose map coordinates are known.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/geometry/calibration.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

struct FloorPoint {
    Eigen::Vector2d pixel;  // px
    Eigen::Vector2d map;    // m, on the floor
};

struct FloorPointsPose {
    UncertainPose3 map_from_camera;                             // as if the intrinsics were exact
    PoseByIntrinsics by_intrinsics = PoseByIntrinsics::Zero();  // how it moves with them
    double rms = 0;                                             // px, per coordinate, corrected for the six fitted numbers; 0 with four points means little
    int worst = 0;                                              // index of the point that fits worst
    double worst_error = 0;                                     // px
};

/// The pose that explains four or more floor points: closed form (homography), then Levenberg-Marquardt on the pixel
/// errors. `sigma` is the noise of each pixel coordinate (px); if the points disagree by clearly more than that, the
/// covariance grows to what they show. Errors: fewer than four points, points (nearly) on one line, pixels that the lens
/// model cannot see, or no camera above the floor that fits.
/// Source: planar homography as in Zhang 2000, section 2; sign and scale from the camera being above the floor.
Result<FloorPointsPose> camera_pose_from_floor_points(const CameraModel& model, const std::vector<FloorPoint>& points, double sigma);

}  // namespace roomfix
