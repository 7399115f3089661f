#include "roomfix/calibrate/printed_board.hpp"

#include <cmath>

namespace roomfix {

Eigen::Matrix<double, 3, smooth_numbers> corner_by_shape(const Chessboard& board, int number) {
    const Eigen::Vector2d far = board.corner(board.corners() - 1);
    const Eigen::Vector2d from_middle = board.corner(number) - far / 2;
    const double half = far.maxCoeff() / 2;
    const double u = from_middle.x() / half, v = from_middle.y() / half;
    Eigen::Matrix<double, 3, smooth_numbers> j = Eigen::Matrix<double, 3, smooth_numbers>::Zero();
    j.row(2).head<3>() << half * u * u, half * u * v, half * v * v;
    j.col(3).head<2>() << -from_middle.x() / 2, from_middle.y() / 2;
    return j;
}

Eigen::Vector3d PrintedBoard::corner(int number) const {
    const Eigen::Vector2d flat = nominal.corner(number);
    return Eigen::Vector3d(flat.x(), flat.y(), 0) + corner_by_shape(nominal, number) * shape + offsets.col(number);
}

void PrintedBoard::move(const Eigen::VectorXd& step) {
    shape += step.head<smooth_numbers>();
    offsets.reshaped() += step.tail(offsets.size());
}

double PrintedBoard::print_error() const {
    double squares = 0;
    for (int i = 0; i < nominal.corners(); ++i) squares += (corner(i).head<2>() - nominal.corner(i)).squaredNorm();
    return std::sqrt(squares / nominal.corners());
}

Eigen::VectorXd PrintedBoard::heights() const {
    Eigen::VectorXd over_plane(nominal.corners());
    for (int i = 0; i < nominal.corners(); ++i) over_plane[i] = corner(i).z();
    return over_plane.array() - over_plane.mean();
}

double PrintedBoard::height() const { return std::sqrt(heights().array().square().mean()); }

}  // namespace roomfix
