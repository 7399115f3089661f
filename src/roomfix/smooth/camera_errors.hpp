// What a session in which robots drove around tells of the cameras' calibrations.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "roomfix/estimate/tracker.hpp"
#include "roomfix/smooth/stretch.hpp"

namespace roomfix {

/// The six independent errors (CalibrationRoot) of one camera: identity and zero before the session.
struct SixErrors {
    int source = 0;  // of the tracker's sources
    SightingCount sightings;
    Vector6d mean = Vector6d::Zero();
    Matrix6d covariance = Matrix6d::Identity();
};

/// Cameras whose calibration is uncertain and that saw robots, in the order of the tracker's sources. All robots' ways, all calibrations and
/// the places of landmarks and corners are estimated together; what several robots tell is added up. `tracked`: the tracker's fixes, in the
/// order of their times; it must have kept its history. `progress` gets 0..1.
std::vector<SixErrors> camera_errors_of(const Tracker& tracker, const std::vector<Fix>& tracked, const std::function<void(double)>& progress = {});

}  // namespace roomfix
