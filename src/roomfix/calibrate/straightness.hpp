// How far the points of an edge are off a straight line, and how far they may be.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "roomfix/calibrate/long_edges.hpp"
#include "roomfix/geometry/camera_model.hpp"

namespace roomfix {

/// How far each point of an edge is off the straight line that fits the edge best without distortion; px of the picture. Points for which the
/// model has no rays are far off, for whatever line.
Eigen::VectorXd crookedness(const CameraModel& model, const LongEdge& edge);

/// Why points of an edge that counts as straight are off their line.
struct EdgeNoise {
    double point = 0.03;  // px^2: each point for itself, with what its neighbours share
    double bend = 0.25;   // px^2: each edge in its own way all along: variance of the Legendre polynomials of second and third order
};

/// An edge's points on the Legendre polynomials over its length: order 2 is a bow, order 3 an S, higher ones are noise of points.
class EdgeShape {
public:
    static constexpr int bow = 2, bends = 2;  // the first order, and how many

    /// Of an edge with least_edge_points or more, not all at one place.
    explicit EdgeShape(const LongEdge& edge);

    int orders() const { return static_cast<int>(basis_.cols()); }
    /// Coefficients of what is off by point: orders() x columns. px
    Eigen::MatrixXd coefficients(const Eigen::MatrixXd& off) const { return from_points_ * off; }
    /// A coefficient's variance (px^2) by the points' noise of 1 px^2.
    double variance(int order) const { return variance_[order]; }
    /// Inverse covariance of the points times `off`, by columns.
    Eigen::MatrixXd weighed(const Eigen::MatrixXd& off, const EdgeNoise& noise) const;

private:
    Eigen::MatrixXd basis_;        // points x orders
    Eigen::MatrixXd from_points_;  // its pseudo-inverse
    Eigen::VectorXd variance_;
};

}  // namespace roomfix
