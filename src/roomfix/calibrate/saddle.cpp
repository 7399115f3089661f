#include "roomfix/calibrate/saddle.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/levenberg_marquardt.hpp"

namespace roomfix {
namespace {

/// The unknowns: place (px), both edges' directions (rad), blur (px), contrast, level, and how the light falls off by x and y (part per px).
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

/// An edge at one pixel: its step, and how the step moves.
struct EdgeAt {
    Step step;
    Eigen::Vector2d by_place;  // of the distance in px
    double by_angle;
    double blurs;
};

EdgeAt edge_at(const Eigen::Vector2d& d, double angle, double bend, double blur) {
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle)), normal(-along.y(), along.x());
    const double t = along.dot(d), n = normal.dot(d);
    const double blurs = (n - 0.5 * bend * t * t) / blur;
    return {Step(blurs), bend * t * along - normal, -t - bend * t * n, blurs};
}

Fit linearise(LumaView picture, const Eigen::Vector2d& start, double radius, const Eigen::Vector2d& bends, const Numbers& n) {
    Fit fit;
    const int reach = static_cast<int>(radius);
    const int u0 = static_cast<int>(std::lround(start.x())), v0 = static_cast<int>(std::lround(start.y()));
    for (int v = v0 - reach; v <= v0 + reach; ++v) {
        for (int u = u0 - reach; u <= u0 + reach; ++u) {
            const Eigen::Vector2d d = Eigen::Vector2d(u, v) - Eigen::Vector2d(n[place_x], n[place_y]);
            if (d.squaredNorm() > radius * radius) continue;
            const EdgeAt a = edge_at(d, n[angle_a], bends[0], n[blur]), b = edge_at(d, n[angle_b], bends[1], n[blur]);
            const double by_a = n[contrast] * a.step.slope * b.step.value / n[blur], by_b = n[contrast] * a.step.value * b.step.slope / n[blur];
            // What the squares reflect, and the light on them: it changes both black and white in proportion.
            const double light = 1 + n[slope_x] * d.x() + n[slope_y] * d.y(), square = n[level] + n[contrast] * a.step.value * b.step.value;
            Numbers by;
            by.head<2>() = light * (by_a * a.by_place + by_b * b.by_place) - square * Eigen::Vector2d(n[slope_x], n[slope_y]);
            by[angle_a] = light * by_a * a.by_angle;
            by[angle_b] = light * by_b * b.by_angle;
            by[blur] = light * (-by_a * a.blurs - by_b * b.blurs);
            by[contrast] = light * a.step.value * b.step.value;
            by[level] = light;
            by[slope_x] = square * d.x();
            by[slope_y] = square * d.y();
            const double residual = picture.row(v)[u] - light * square;
            fit.information += by * by.transpose();
            fit.pull += residual * by;
            fit.squares += residual * residual;
            ++fit.pixels;
        }
    }
    return fit;
}

}  // namespace

std::optional<Saddle> fit_saddle(LumaView picture, const Eigen::Vector2d& start, const SaddleEdge& a, const SaddleEdge& b, double radius) {
    const double margin = radius + 1;
    if (!(start.x() >= margin && start.y() >= margin && start.x() <= picture.width - 1 - margin && start.y() <= picture.height - 1 - margin))
        return std::nullopt;
    Numbers n;
    n << start, std::atan2(a.along.y(), a.along.x()), std::atan2(b.along.y(), b.along.x()), 1, 0, 128, 0, 0;
    const Eigen::Vector2d bends(a.bend, b.bend);
    // The light's own numbers are linear: with no contrast to begin with, the first step finds them, and only them.
    Fit fit = linearise(picture, start, radius, bends, n);
    if (fit.pixels <= 2 * unknowns) return std::nullopt;
    int round = 0;
    const bool possible = levenberg_marquardt({.start = 0, .least = 1e-4, .most = 1e6, .rounds = 25}, [&](double damping) {
        Normal information = fit.information;
        if (round++ == 0) information.topLeftCorner<5, 5>().diagonal().setConstant(1);
        const Numbers step = damped_step(information, fit.pull, damping);
        if (!step.allFinite()) return StepResult::impossible;
        Numbers next = n + step;
        next[blur] = std::clamp(next[blur], least_blur, widest_blur);
        const Fit tried = linearise(picture, start, radius, bends, next);
        if (tried.squares > fit.squares) return StepResult::worse;
        n = next;
        fit = tried;
        if ((n.head<2>() - start).norm() > farthest) return StepResult::impossible;
        return step.head<2>().norm() < 1e-4 && round > 2 ? StepResult::settled : StepResult::better;
    });
    if (!possible) return std::nullopt;
    const double variance = fit.squares / (fit.pixels - unknowns);
    if (n[contrast] * n[contrast] < 25 * variance) return std::nullopt;  // hardly a pattern at all
    const Normal covariance = variance * fit.information.inverse();
    if (!covariance.allFinite()) return std::nullopt;
    return Saddle{n.head<2>(), covariance.topLeftCorner<2, 2>(), n[blur]};
}

}  // namespace roomfix
