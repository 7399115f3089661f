// A lens's distortion without any board: edges of a room that are straight must be straight in the picture, too.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/calibrate/long_edges.hpp"
#include "roomfix/geometry/camera_model.hpp"

namespace roomfix {

struct PlumbLineSettings {
    std::size_t least_lines = 12;    // that are believed
    double outlier = 3;              // an edge that is so many times less straight than most, or than its noise says, is bent in truth
    double tangential_sigma = 5e-4;  // of p1 and p2 before anything is seen
    double centre_sigma = 0.03;      // of the picture's width: how far the lens's middle may be off the one in the model, each coordinate
};

struct PlumbLine {
    CameraModel model;                                       // plumb_bob; k1, k2, p1, p2 and the image centre are found, the focal length stays
    IntrinsicsMatrix covariance = IntrinsicsMatrix::Zero();  // of these six, for this focal length
    std::vector<LongEdge> edges;                             // the longest first; one that is in several pictures, once
    int used = 0;
    double before = 0;  // px rms by which the used edges are off straight lines with the lens that was given ...
    double rms = 0;     // ... and with the one that was found
};

/// Least squares over k1, k2, p1, p2 and the image centre, the last four with priors; each edge has its own straight line. How far points are off and how much
/// edges that count as straight are bent in truth is learned from these edges; those that are bent more are left out. Errors: too few edges, or a lens that
/// they do not fix. Source: Brown 1971, analytical plumb line calibration.
Result<PlumbLine> straighten(std::vector<LongEdge> edges, const CameraModel& start, const PlumbLineSettings& settings = {});

/// Its covariance with what is known of fx and fy from elsewhere: for a longer focal length the same bending has larger numbers.
IntrinsicsMatrix covariance_with_focal(const PlumbLine& found, const IntrinsicsMatrix& known);

}  // namespace roomfix
