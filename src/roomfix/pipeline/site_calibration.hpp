// All cameras of a site calibrated at once, by the robots that drove through them.
#pragma once

#include <vector>

#include "roomfix/estimate/tracking_models.hpp"
#include "roomfix/site/site.hpp"
#include "roomfix/smooth/camera_errors.hpp"

namespace roomfix {

struct SiteCalibration {
    SiteCamera camera;                       // as it is now: its pose or mount, and its intrinsics where they were uncertain
    SightingCount sightings;                 // of robots, or of landmarks and corners
    Vector6d moved = Vector6d::Zero();       // error vector that its pose in the map, or on the robot, had
    Matrix6d covariance = Matrix6d::Zero();  // of that pose now, with what the intrinsics leave open
    double surprise = 0;                     // the error that was least expected, in standard deviations of what was stated
    double error_before = 0, error_now = 0;  // m, root mean square: over the floor in sight, or by the mount's tilt under a ceiling 2.5 m above
};

/// `errors`: of cameras of the models' site.
std::vector<SiteCalibration> calibrated_cameras(const TrackingModels& models, const std::vector<SixErrors>& errors);

}  // namespace roomfix
