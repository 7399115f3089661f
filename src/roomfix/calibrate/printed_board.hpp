// A chessboard as it really is: printed not quite evenly, on something that is not quite flat.
#pragma once

#include <Eigen/Core>

#include "roomfix/calibrate/chessboard.hpp"

namespace roomfix {

/// Smooth differences: the height over the plane of the board, in halves of its longer side, is b0 u^2 + b1 u v + b2 v^2 where u and v count the
/// same halves from its middle, along the rows and along the columns; then how much longer columns are than rows.
constexpr int smooth_numbers = 4;
using SmoothShape = Eigen::Matrix<double, smooth_numbers, 1>;

/// How a corner's place moves with them, m.
Eigen::Matrix<double, 3, smooth_numbers> corner_by_shape(const Chessboard& board, int number);

/// The same in all shots.
struct PrintedBoard {
    Chessboard nominal;
    SmoothShape shape = SmoothShape::Zero();
    Eigen::Matrix3Xd offsets;  // m, of each corner besides; the third is its height

    explicit PrintedBoard(const Chessboard& board) : nominal(board), offsets(Eigen::Matrix3Xd::Zero(3, board.corners())) {}

    /// Place of a corner in the frame of the board, m.
    Eigen::Vector3d corner(int number) const;
    /// The smooth numbers, then three for each corner.
    int numbers() const { return smooth_numbers + static_cast<int>(offsets.size()); }
    void move(const Eigen::VectorXd& step);

    /// Of the corners over their mean, m.
    Eigen::VectorXd heights() const;
    /// Root mean square of how far corners are from where they should have been printed, and from the board's plane, m.
    double print_error() const;
    double height() const;
};

}  // namespace roomfix
