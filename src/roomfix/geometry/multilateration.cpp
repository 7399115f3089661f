#include "roomfix/geometry/multilateration.hpp"

#include <cmath>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

constexpr double line_like = 0.02;  // spread across / along below which centres count as lying on a line

}  // namespace

FixedList<Eigen::Vector2d, 2> meeting_points(std::span<const Circle> circles) {
    FixedList<Eigen::Vector2d, 2> points;
    if (circles.size() < 2) return points;
    const double count = static_cast<double>(circles.size());
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const Circle& c : circles) middle += c.centre / count;
    // With q = p - middle and o_i = centre_i - middle: 2 o_i . q = |o_i|^2 - r_i^2 + s, s = mean of r^2 - |o|^2.
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    double s = 0;
    for (const Circle& c : circles) s += (c.radius * c.radius - (c.centre - middle).squaredNorm()) / count;
    for (const Circle& c : circles) {
        const Eigen::Vector2d o = c.centre - middle;
        normal += o * o.transpose();
        right += 0.5 * o * (o.squaredNorm() - c.radius * c.radius + s);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(normal);
    const double along = axes.eigenvalues()[1];
    if (!(along > 1e-12)) return points;
    const Eigen::Vector2d main = axes.eigenvectors().col(1);
    const Eigen::Vector2d across = axes.eigenvectors().col(0);
    const double u = main.dot(right) / along;
    if (axes.eigenvalues()[0] > line_like * line_like * along) {
        points.push_back(middle + u * main + across * (across.dot(right) / axes.eigenvalues()[0]));
        return points;
    }
    // |q|^2 = s on average: what is left is the distance from the line.
    const double v = std::sqrt(std::max(s - u * u, 0.0));
    points.push_back(middle + u * main + v * across);
    if (v > 0) points.push_back(middle + u * main - v * across);
    return points;
}

}  // namespace roomfix
