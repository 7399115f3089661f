// What is left uncertain of a smoothed trajectory.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "roomfix/smooth/trajectory.hpp"

namespace roomfix {

/// Covariance of two neighbouring knots together.
using PairCovariance = Eigen::Matrix<double, 12, 12>;

/// `jacobian`: of all whitened residuals by all knots (six columns each, in their order) and then by what they have in common (slow
/// errors). A residual may depend on two neighbouring knots at most. One pair for each piece between knots. Time grows in proportion to
/// the knots. Empty where the information matrix is singular.
/// Source: block tridiagonal inverse by two sweeps (as the Rauch-Tung-Striebel smoother), bordered by the common unknowns.
std::vector<PairCovariance> knot_covariances(const Eigen::SparseMatrix<double, Eigen::RowMajor>& jacobian, std::size_t knots);

}  // namespace roomfix
