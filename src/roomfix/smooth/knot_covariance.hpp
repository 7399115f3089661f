// What is left uncertain of a smoothed trajectory.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "roomfix/smooth/trajectory.hpp"

namespace roomfix {

/// Covariance of two neighbouring knots together.
using PairCovariance = Eigen::Matrix<double, 12, 12>;

struct SmoothedCovariance {
    std::vector<PairCovariance> pairs;  // one for each piece between knots; empty where the information matrix is singular
    Eigen::MatrixXd common;             // of what the knots have in common
};

/// `jacobian`: of all whitened residuals by all knots (six columns each, in their order) and then by what they have in common (slow
/// errors). A residual may depend on two neighbouring knots at most. Time grows in proportion to the knots.
/// Source: block tridiagonal inverse by two sweeps (as the Rauch-Tung-Striebel smoother), bordered by the common unknowns.
SmoothedCovariance smoothed_covariance(const Eigen::SparseMatrix<double, Eigen::RowMajor>& jacobian, std::size_t knots);

}  // namespace roomfix
