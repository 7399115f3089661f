#include "roomfix/calibrate/saddle.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

/// The unknowns: place (px), both edges' directions (rad), blur (px), contrast, and the plane of light: level, slopes by x and y.
enum Unknown { place_x, place_y, angle_a, angle_b, blur, contrast, level, slope_x, slope_y, unknowns };
using Numbers = Eigen::Matrix<double, unknowns, 1>;
using Normal = Eigen::Matrix<double, unknowns, unknowns>;

constexpr double least_blur = 0.25, widest_blur = 4;  // px
constexpr double farthest = 1.5;                      // px from the start

struct Fit {
    Normal information = Normal::Zero();
    Numbers pull = Numbers::Zero();
    double squares = 0;
    int pixels = 0;
};

/// A step across an edge: -1 to 1, with its derivative by the distance in blurs.
struct Step {
    double value, slope;
    explicit Step(double blurs)
        : value(std::erf(blurs / std::numbers::sqrt2)), slope(std::numbers::sqrt2 * std::numbers::inv_sqrtpi * std::exp(-0.5 * blurs * blurs)) {}
};

Fit linearise(LumaView picture, const Eigen::Vector2d& start, double radius, const Numbers& n) {
    Fit fit;
    const Eigen::Vector2d along_a(std::cos(n[angle_a]), std::sin(n[angle_a])), along_b(std::cos(n[angle_b]), std::sin(n[angle_b]));
    const Eigen::Vector2d normal_a(-along_a.y(), along_a.x()), normal_b(-along_b.y(), along_b.x());
    const int reach = static_cast<int>(radius);
    const int u0 = static_cast<int>(std::lround(start.x())), v0 = static_cast<int>(std::lround(start.y()));
    for (int v = v0 - reach; v <= v0 + reach; ++v) {
        for (int u = u0 - reach; u <= u0 + reach; ++u) {
            const Eigen::Vector2d d = Eigen::Vector2d(u, v) - Eigen::Vector2d(n[place_x], n[place_y]);
            if (d.squaredNorm() > radius * radius) continue;
            const double off_a = normal_a.dot(d) / n[blur], off_b = normal_b.dot(d) / n[blur];
            const Step a(off_a), b(off_b);
            const double by_a = n[contrast] * a.slope * b.value / n[blur], by_b = n[contrast] * a.value * b.slope / n[blur];
            Numbers by;
            by[place_x] = -by_a * normal_a.x() - by_b * normal_b.x() - n[slope_x];
            by[place_y] = -by_a * normal_a.y() - by_b * normal_b.y() - n[slope_y];
            by[angle_a] = -by_a * along_a.dot(d);
            by[angle_b] = -by_b * along_b.dot(d);
            by[blur] = -by_a * off_a - by_b * off_b;
            by[contrast] = a.value * b.value;
            by[level] = 1;
            by[slope_x] = d.x();
            by[slope_y] = d.y();
            const double predicted = n[level] + n[slope_x] * d.x() + n[slope_y] * d.y() + n[contrast] * a.value * b.value;
            const double residual = picture.row(v)[u] - predicted;
            fit.information += by * by.transpose();
            fit.pull += residual * by;
            fit.squares += residual * residual;
            ++fit.pixels;
        }
    }
    return fit;
}

}  // namespace

std::optional<Saddle> fit_saddle(LumaView picture, const Eigen::Vector2d& start, const Eigen::Vector2d& along_a, const Eigen::Vector2d& along_b, double radius) {
    const double margin = radius + 1;
    if (!(start.x() >= margin && start.y() >= margin && start.x() <= picture.width - 1 - margin && start.y() <= picture.height - 1 - margin)) return std::nullopt;
    Numbers n;
    n << start, std::atan2(along_a.y(), along_a.x()), std::atan2(along_b.y(), along_b.x()), 1, 0, 128, 0, 0;
    // The light's own numbers are linear: with no contrast to begin with, the first step finds them, and only them.
    double damping = 0;
    Fit fit = linearise(picture, start, radius, n);
    if (fit.pixels <= 2 * unknowns) return std::nullopt;
    for (int round = 0; round < 25; ++round) {
        Normal damped = fit.information;
        if (round == 0) damped.topLeftCorner<5, 5>().diagonal().setConstant(1);
        damped.diagonal() *= 1 + damping;
        const Numbers step = damped.ldlt().solve(fit.pull);
        if (!step.allFinite()) return std::nullopt;
        Numbers next = n + step;
        next[blur] = std::clamp(next[blur], least_blur, widest_blur);
        const Fit tried = linearise(picture, start, radius, next);
        if (tried.squares > fit.squares) {
            damping = std::max(4 * damping, 1e-3);
            if (damping > 1e6) break;
            continue;
        }
        n = next;
        fit = tried;
        damping *= 0.2;
        if ((n.head<2>() - start).norm() > farthest) return std::nullopt;
        if (step.head<2>().norm() < 1e-4 && round > 1) break;
    }
    const double variance = fit.squares / (fit.pixels - unknowns);
    if (n[contrast] * n[contrast] < 25 * variance) return std::nullopt;  // hardly a pattern at all
    const Normal covariance = variance * fit.information.inverse();
    if (!covariance.allFinite()) return std::nullopt;
    return Saddle{n.head<2>(), covariance.topLeftCorner<2, 2>(), n[blur]};
}

}  // namespace roomfix
