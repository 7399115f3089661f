// What many exact floor points say about the lens itself.
#pragma once

#include <optional>
#include <vector>

#include "roomfix/geometry/floor_points.hpp"

namespace roomfix {

/// How far stated intrinsics commonly are off where nobody states their covariance: focus and zoom were touched since, or the lens was
/// calibrated from few pictures.
struct LensPrior {
    double focal = 0.03;         // of the focal length, common to x and y
    double aspect = 0.003;       // of fx against fy
    double centre = 0.012;       // of the picture's width
    double distortion = 0.3;     // of each of the distortion's numbers ...
    double least_radial = 0.03;  // ... but at least this, of radial ones
    double tangential = 0.002;
};

/// The camera as the floor points show it.
struct FloorLens {
    CameraModel model;
    UncertainPose3 map_from_camera;  // as if the intrinsics were exact
    IntrinsicsErrors intrinsics;
    double rms = 0;       // px, per coordinate
    double evidence = 0;  // by which the points speak against the stated lens: difference of the Bayesian information criterion
};

constexpr std::size_t enough_floor_points = 12;

/// Fits pose and intrinsics together to the floor points, starting at what is stated. Nothing where fewer than `enough_floor_points` are given,
/// or they do not speak against the lens as stated (Schwarz 1978: a difference above 10 is very strong evidence).
std::optional<FloorLens> lens_from_floor_points(const CameraModel& model, const FloorPointsPose& pose, const std::vector<FloorPoint>& points,
                                                const LensPrior& prior = {});

}  // namespace roomfix
