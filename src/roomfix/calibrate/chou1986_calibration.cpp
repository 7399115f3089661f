#include "roomfix/calibrate/chou1986_calibration.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {

Result<IdealGrid> ideal_grid(const std::vector<Eigen::Vector2d>& seen, const Chessboard& grid, const Eigen::Vector2d& centre) {
    if (static_cast<int>(seen.size()) != grid.corners() || grid.columns < 3 || grid.rows < 3) {
        return Error{fmt::format("{} points seen, the grid has {}: all of it must be in the picture", seen.size(), grid.corners())};
    }
    // The nine points around the middle; x' = a x - b y + c, y' = b x + a y + d.
    std::vector<int> order(seen.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    const auto far = [&](int i) { return (seen[static_cast<std::size_t>(i)] - centre).squaredNorm(); };
    std::sort(order.begin(), order.end(), [&](int a, int b) { return far(a) < far(b); });
    const auto on_grid = [&](int i) { return Eigen::Vector2d(i % grid.columns, i / grid.columns); };
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (std::size_t n = 0; n < 9; ++n) {
        const Eigen::Vector2d p = on_grid(order[n]);
        Eigen::Matrix<double, 2, 4> row;
        row << p.x(), -p.y(), 1, 0, p.y(), p.x(), 0, 1;
        normal += row.transpose() * row;
        right += row.transpose() * seen[static_cast<std::size_t>(order[n])];
    }
    const Eigen::FullPivLU<Eigen::Matrix4d> factor(normal);
    if (!factor.isInvertible()) return Error{"the grid's middle points lie on one line: hold the grid before the middle of the picture"};
    const Eigen::Vector4d s = factor.solve(right);
    IdealGrid ideal;
    ideal.spacing = std::hypot(s[0], s[1]);
    for (int i = 0; i < grid.corners(); ++i) {
        const Eigen::Vector2d p = on_grid(i);
        ideal.points.emplace_back(s[0] * p.x() - s[1] * p.y() + s[2], s[1] * p.x() + s[0] * p.y() + s[3]);
    }
    return ideal;
}

std::optional<double> focal_length(double spacing_px, double distance, double square) {
    if (!(spacing_px > 0 && distance > 0 && square > 0)) return std::nullopt;
    return spacing_px * distance / square;
}

std::optional<Eigen::Vector2d> image_centre(const Eigen::Vector2d& a0, const Eigen::Vector2d& a1, const Eigen::Vector2d& b0, const Eigen::Vector2d& b1) {
    const Eigen::Vector3d a = a0.homogeneous().cross(a1.homogeneous()), b = b0.homogeneous().cross(b1.homogeneous());
    const Eigen::Vector3d meeting = a.normalized().cross(b.normalized());
    if (std::abs(meeting.z()) < 1e-9 * meeting.head<2>().norm() || meeting.norm() < 1e-12) return std::nullopt;
    return Eigen::Vector2d(meeting.head<2>() / meeting.z());
}

IntrinsicsMatrix published_covariance(double focal, double distance, double distance_sigma, double centre_sigma) {
    IntrinsicsMatrix covariance = IntrinsicsMatrix::Zero();
    const double sigma = focal * distance_sigma / distance;
    covariance.topLeftCorner<2, 2>().setConstant(sigma * sigma);
    covariance(2, 2) = covariance(3, 3) = centre_sigma * centre_sigma;
    return covariance;
}

void correct_picture(LumaView seen, const LensGrid& grid, LumaImage& corrected) {
    corrected.resize(seen.width, seen.height);
    for (int y = 0; y < seen.height; ++y) {
        for (int x = 0; x < seen.width; ++x) {
            const auto from = grid.distorted({x, y});
            const bool inside = from && from->x() >= 0 && from->y() >= 0 && from->x() < seen.width - 1 && from->y() < seen.height - 1;
            corrected.row(y)[x] =
                inside ? static_cast<std::uint8_t>(std::lround(sample(seen, static_cast<float>(from->x()), static_cast<float>(from->y())))) : 0;
        }
    }
}

}  // namespace roomfix
