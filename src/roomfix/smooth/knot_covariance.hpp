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
    Eigen::MatrixXd common;             // of what all slices have in common
};

/// Which unknown is in which column.
struct UnknownColumns {
    std::vector<Eigen::Index> slices;  // how many columns each slice of time has, in the order of the slices
    std::vector<Eigen::Index> knots;   // the first of each knot's six columns
};

/// `jacobian`: of all whitened residuals by the unknowns of each slice of time (knots and what changes fast), and then by what the slices
/// have in common (slow errors). A residual may depend on two neighbouring slices at most. Time grows in proportion to the slices.
/// Source: block tridiagonal inverse by two sweeps (as the Rauch-Tung-Striebel smoother), bordered by the common unknowns.
SmoothedCovariance smoothed_covariance(const Eigen::SparseMatrix<double, Eigen::RowMajor>& jacobian, const UnknownColumns& columns);

}  // namespace roomfix
