#include "roomfix/geometry/camera_model.hpp"

#include <Eigen/LU>
#include <cmath>

namespace roomfix {
namespace {

/// The distorted point and, in `jacobian`, its derivative by the undistorted one.
Eigen::Vector2d distort(const CameraModel& model, const Eigen::Vector2d& p, Eigen::Matrix2d* jacobian) {
    const auto [k1, k2, p1, p2, k3] = model.distortion;
    const double x = p.x();
    const double y = p.y();
    const double r2 = x * x + y * y;
    const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
    if (jacobian) {
        const double slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3));  // d(radial)/d(r^2) * 2
        const double cross = slope * x * y + 2 * p1 * x + 2 * p2 * y;
        *jacobian << radial + slope * x * x + 2 * p1 * y + 6 * p2 * x, cross, cross, radial + slope * y * y + 6 * p1 * y + 2 * p2 * x;
    }
    return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

double radial_value(const CameraModel& model, double r) {
    const double s = r * r;
    return r * (1 + s * (model.distortion[0] + s * (model.distortion[1] + s * model.distortion[4])));
}

double radial_slope(const CameraModel& model, double s) {
    return 1 + s * (3 * model.distortion[0] + s * (5 * model.distortion[1] + s * 7 * model.distortion[4]));
}

/// The undistorted radius for a distorted one, on the rising branch, to about 1e-8: the caller's Newton steps do the rest. Nothing
/// above its top.
std::optional<double> invert_radius(const CameraModel& model, double distorted) {
    double low = 0;
    double high = std::sqrt(std::min(model.max_radius_squared, 1e8));
    if (radial_value(model, high) < distorted) return std::nullopt;
    double r = std::min(distorted, high);
    for (int i = 0; i < 80; ++i) {
        const double excess = radial_value(model, r) - distorted;
        (excess > 0 ? high : low) = r;
        const double slope = radial_slope(model, r * r);
        double next = slope > 1e-12 ? r - excess / slope : low;
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        if (std::abs(next - r) <= 1e-8 * (1 + r)) return next;
        r = next;
    }
    return r;
}

}  // namespace

void CameraModel::prepare() {
    // The smallest s = r^2 > 0 with d(r radial)/dr = 1 + 3 k1 s + 5 k2 s^2 + 7 k3 s^3 = 0: scan outwards in growing steps
    // (a lens sees at most r = 30, i.e. 88 deg off axis), then bisect.
    constexpr double farthest = 900;
    max_radius_squared = farthest;
    double inner = 0;
    for (double outer = 1e-4; outer < farthest; outer *= 1.01) {
        if (radial_slope(*this, outer) <= 0) {
            double low = inner;
            double high = outer;
            for (int i = 0; i < 100; ++i) {
                const double middle = 0.5 * (low + high);
                (radial_slope(*this, middle) > 0 ? low : high) = middle;
            }
            max_radius_squared = low;
            return;
        }
        inner = outer;
    }
}

CameraModel make_camera_model(int width, int height, double fx, double fy, double cx, double cy, const std::array<double, 5>& distortion) {
    CameraModel model{width, height, fx, fy, cx, cy, distortion};
    model.prepare();
    return model;
}

std::optional<Eigen::Vector2d> project(const CameraModel& model, const Eigen::Vector3d& point_camera, ProjectionJacobian* jacobian) {
    if (!(point_camera.z() > 1e-9)) return std::nullopt;
    const double inverse_z = 1 / point_camera.z();
    const Eigen::Vector2d normalised = point_camera.head<2>() * inverse_z;
    if (!(normalised.squaredNorm() < model.max_radius_squared)) return std::nullopt;
    Eigen::Matrix2d bend;
    const Eigen::Vector2d bent = distort(model, normalised, &bend);
    if (!(bend.determinant() > 0)) return std::nullopt;
    if (jacobian) {
        const Eigen::Vector2d focal(model.fx, model.fy);
        jacobian->leftCols<2>() = focal.asDiagonal() * bend * inverse_z;
        jacobian->col(2) = -(jacobian->leftCols<2>() * normalised);
    }
    return Eigen::Vector2d(model.fx * bent.x() + model.cx, model.fy * bent.y() + model.cy);
}

std::optional<Eigen::Vector2d> unproject(const CameraModel& model, const Eigen::Vector2d& pixel, Eigen::Matrix2d* jacobian) {
    const Eigen::Vector2d target((pixel.x() - model.cx) / model.fx, (pixel.y() - model.cy) / model.fy);
    const double distorted_radius = target.norm();
    if (!std::isfinite(distorted_radius)) return std::nullopt;
    const auto radius = invert_radius(model, distorted_radius);
    if (!radius) return std::nullopt;
    Eigen::Vector2d p = distorted_radius > 0 ? Eigen::Vector2d(target * (*radius / distorted_radius)) : target;

    // The radial part is inverted; Newton adds the tangential part.
    const double tolerance = 1e-10 / std::max(model.fx, model.fy);
    for (int i = 0; i < 30; ++i) {
        Eigen::Matrix2d bend;
        const Eigen::Vector2d miss = distort(model, p, &bend) - target;
        const double determinant = bend.determinant();
        if (!(determinant > 0) || !(p.squaredNorm() < model.max_radius_squared)) return std::nullopt;
        if (miss.cwiseAbs().maxCoeff() <= tolerance) {
            if (jacobian) *jacobian = bend.inverse() * Eigen::Vector2d(1 / model.fx, 1 / model.fy).asDiagonal();
            return p;
        }
        p -= bend.inverse() * miss;
    }
    return std::nullopt;
}

}  // namespace roomfix
