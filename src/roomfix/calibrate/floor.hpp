// A fixed camera's pose from whatever is known of the floor it sees: clicked points, a grid of tiles, tags, and from a room's corner.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/geometry/view.hpp"

namespace roomfix {

/// A point of the floor in the picture. A line tells only about the direction across it: its information has rank one then.
struct FloorSighting {
    Eigen::Vector2d pixel;        // px
    Eigen::Vector2d map;          // m, on the floor
    Eigen::Matrix2d information;  // px^-2
};

FloorSighting clicked_point(const Eigen::Vector2d& pixel, const Eigen::Vector2d& map, double sigma);

/// One thing that tells where the camera is.
struct FloorSource {
    std::string name;  // for the report
    std::vector<FloorSighting> sightings;
    std::optional<UncertainPose3> pose;               // what a corner says of the whole camera
    double scale_sigma = 0;                           // part by which all its lengths from `about` may be off together
    Eigen::Vector2d about = Eigen::Vector2d::Zero();  // m
    double place_sigma = 0;                           // m: of each map coordinate, by which all of it may be off together
    bool outliers = false;                            // some of its sightings may be of something else
};

/// What one source is worth.
struct FloorContribution {
    std::string name;
    int sightings = 0;
    double rms = 0;               // px, of what its sightings tell
    std::optional<double> alone;  // m: floor error (rms) that it alone would leave; nothing where it does not fix the pose
    double share = 0;             // of what is known of the pose: all add up to 1
};

struct FloorCalibration {
    UncertainPose3 map_from_camera;                             // as if the intrinsics were exact
    PoseByIntrinsics by_intrinsics = PoseByIntrinsics::Zero();  // how it moves with them
    double rms = 0;                                             // px
    double floor_error = 0;                                     // m, rms over the floor in sight, with the intrinsics' errors
    std::vector<FloorContribution> contributions;
    /// Another place of the camera from which all would look nearly the same: a small tile is seen alike from two directions.
    std::optional<Eigen::Isometry3d> rival;
};

/// Weighted least squares over all sources, each with its own covariance. `start`: about where the camera is; without it, four points or a
/// corner must tell. Errors say what is missing.
Result<FloorCalibration> calibrate_floor(const CameraModel& model, const IntrinsicsMatrix& intrinsics, const std::vector<FloorSource>& sources,
                                         const std::optional<UncertainPose3>& start = {});

/// Standard deviation (m, both directions together) of where a point of the floor is taken to be, by the calibration's errors alone.
/// Nothing where the camera does not see the floor there.
std::optional<double> floor_sigma(const View& view, const Eigen::Vector2d& pixel);
/// Its root mean square over the floor in sight, up to eight times the camera's height away.
double floor_error(const View& view);

}  // namespace roomfix
