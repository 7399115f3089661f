#include "roomfix/geometry/camera_model.hpp"

#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/geometry/lens_grid.hpp"

namespace roomfix {
namespace {

/// How much farther from the axis a ray at r^2 = s ends up: the factor g, and 2 dg/ds.
struct Stretch {
    double factor = 1;
    double slope = 0;
};

Stretch polynomial(double k1, double k2, double k3, double s) { return {1 + s * (k1 + s * (k2 + s * k3)), 2 * (k1 + s * (2 * k2 + s * 3 * k3))}; }

Stretch stretch_at(const CameraModel& model, double s) {
    const auto& d = model.distortion;
    switch (model.kind) {
        case Distortion::plumb_bob:
            return polynomial(d[0], d[1], d[4], s);
        case Distortion::rational_polynomial: {
            const Stretch above = polynomial(d[0], d[1], d[4], s), below = polynomial(d[5], d[6], d[7], s);
            return {above.factor / below.factor, (above.slope - above.factor / below.factor * below.slope) / below.factor};
        }
        case Distortion::equidistant:
            break;
    }
    if (s < 1e-10) return {1 + s * (d[0] - 1.0 / 3), 2 * (d[0] - 1.0 / 3)};
    const double r = std::sqrt(s), t = std::atan(r), t2 = t * t;
    const double bent = t * (1 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3]))));
    const double by_r = (1 + t2 * (3 * d[0] + t2 * (5 * d[1] + t2 * (7 * d[2] + t2 * 9 * d[3])))) / (1 + s);
    return {bent / r, (by_r - bent / r) / s};
}

/// p1 and p2, where the kind has them.
Eigen::Vector2d tangential(const CameraModel& model) {
    return model.kind == Distortion::equidistant ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(model.distortion[2], model.distortion[3]);
}

/// The distorted point and, in `jacobian`, its derivative by the undistorted one.
Eigen::Vector2d distort(const CameraModel& model, const Eigen::Vector2d& p, Eigen::Matrix2d* jacobian) {
    const double x = p.x(), y = p.y(), r2 = x * x + y * y;
    const Stretch g = stretch_at(model, r2);
    const Eigen::Vector2d t = tangential(model);
    const double p1 = t.x(), p2 = t.y();
    if (jacobian) {
        const double cross = g.slope * x * y + 2 * p1 * x + 2 * p2 * y;
        *jacobian << g.factor + g.slope * x * x + 2 * p1 * y + 6 * p2 * x, cross, cross, g.factor + g.slope * y * y + 6 * p1 * y + 2 * p2 * x;
    }
    return {x * g.factor + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * g.factor + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

/// Derivatives of the distorted point by the distortion's numbers.
Eigen::Matrix<double, 2, most_distortion> by_distortion(const CameraModel& model, const Eigen::Vector2d& p) {
    Eigen::Matrix<double, 2, most_distortion> by = Eigen::Matrix<double, 2, most_distortion>::Zero();
    const double x = p.x(), y = p.y(), s = p.squaredNorm();
    if (model.kind == Distortion::equidistant) {
        const double r = std::sqrt(s), t = std::atan(r);
        double power = r > 1e-9 ? t * t * t / r : s;
        for (int i = 0; i < 4; ++i, power *= t * t) by.col(i) = power * p;
        return by;
    }
    const auto& d = model.distortion;
    const bool rational = model.kind == Distortion::rational_polynomial;
    const double below = rational ? polynomial(d[5], d[6], d[7], s).factor : 1;
    const Eigen::Vector3d powers(s, s * s, s * s * s);
    const int above_columns[3] = {0, 1, 4};
    for (int i = 0; i < 3; ++i) {
        by.col(above_columns[i]) = powers[i] / below * p;
        if (rational) by.col(5 + i) = -polynomial(d[0], d[1], d[4], s).factor * powers[i] / (below * below) * p;
    }
    by.col(2) << 2 * x * y, s + 2 * y * y;
    by.col(3) << s + 2 * x * x, 2 * x * y;
    return by;
}

double radial_value(const CameraModel& model, double r) { return r * stretch_at(model, r * r).factor; }

/// d(radial_value)/dr at r^2 = s.
double radial_slope(const CameraModel& model, double s) {
    const Stretch g = stretch_at(model, s);
    return g.factor + s * g.slope;
}

/// The undistorted radius for a distorted one, on the rising branch, to about 1e-8: the caller's Newton steps do the rest. Nothing
/// above its top, but for the little that the tangential part may add.
std::optional<double> invert_radius(const CameraModel& model, double distorted) {
    double low = 0;
    double high = std::sqrt(std::min(model.max_radius_squared, 1e8));
    const double top = radial_value(model, high);
    if (top < 0.98 * distorted) return std::nullopt;
    if (top < distorted) return high * 0.99;
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

const char* name_of(Distortion kind) {
    static constexpr std::array names = {"plumb_bob", "rational_polynomial", "equidistant"};
    return names[static_cast<std::size_t>(kind)];
}

std::optional<Distortion> distortion_named(std::string_view name) {
    for (const Distortion kind : {Distortion::plumb_bob, Distortion::rational_polynomial, Distortion::equidistant}) {
        if (name == name_of(kind)) return kind;
    }
    return std::nullopt;
}

IntrinsicsVector CameraModel::intrinsics() const {
    IntrinsicsVector numbers;
    numbers << fx, fy, cx, cy, Eigen::Map<const Eigen::Matrix<double, most_distortion, 1>>(distortion.data());
    return numbers;
}

void CameraModel::set_intrinsics(const IntrinsicsVector& numbers) {
    fx = numbers[0];
    fy = numbers[1];
    cx = numbers[2];
    cy = numbers[3];
    Eigen::Map<Eigen::Matrix<double, most_distortion, 1>>(distortion.data()) = numbers.tail<most_distortion>();
    prepare();
}

void CameraModel::prepare() {
    // The smallest s = r^2 > 0 where the bent radius stops growing, or jumps through infinity: scan outwards in growing steps (a lens sees
    // at most r = 30, i.e. 88 deg off axis), then bisect.
    constexpr double farthest = 900;
    const auto grows = [this](double s) { return stretch_at(*this, s).factor > 0 && radial_slope(*this, s) > 0; };
    max_radius_squared = farthest;
    double inner = 0;
    for (double outer = 1e-4; outer < farthest; inner = outer, outer *= 1.01) {
        if (grows(outer)) continue;
        double low = inner;
        double high = outer;
        for (int i = 0; i < 100; ++i) {
            const double middle = 0.5 * (low + high);
            (grows(middle) ? low : high) = middle;
        }
        max_radius_squared = low * (1 - 1e-9);  // not so near to a pole that rounding jumps over it
        return;
    }
}

CameraModel make_camera_model(int width, int height, double fx, double fy, double cx, double cy, const std::array<double, most_distortion>& distortion,
                              Distortion kind) {
    CameraModel model{width, height, fx, fy, cx, cy, distortion, kind};
    model.prepare();
    return model;
}

std::optional<Eigen::Vector2d> project(const CameraModel& model, const Eigen::Vector3d& point_camera, ProjectionJacobian* jacobian,
                                       IntrinsicsJacobian* by_intrinsics) {
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
    if (by_intrinsics) {
        by_intrinsics->leftCols<4>() << bent.x(), 0, 1, 0, 0, bent.y(), 0, 1;
        by_intrinsics->rightCols<most_distortion>() = Eigen::Vector2d(model.fx, model.fy).asDiagonal() * by_distortion(model, normalised);
    }
    const Eigen::Vector2d pixel(model.fx * bent.x() + model.cx, model.fy * bent.y() + model.cy);
    if (!model.grid) return pixel;
    Eigen::Matrix2d by_ideal;
    const auto seen = model.grid->distorted(pixel, &by_ideal);
    if (seen && jacobian) *jacobian = (by_ideal * *jacobian).eval();
    if (seen && by_intrinsics) *by_intrinsics = (by_ideal * *by_intrinsics).eval();
    return seen;
}

namespace {

/// A pixel as a point on the plane at distance 1, still distorted.
Eigen::Vector2d without_focal(const CameraModel& model, const Eigen::Vector2d& pixel) {
    return {(pixel.x() - model.cx) / model.fx, (pixel.y() - model.cy) / model.fy};
}

/// Newton's steps from `p` to the undistorted point of `target`; nothing after so many. Steps that leave the invertible part are halved.
std::optional<Eigen::Vector2d> newton_unproject(const CameraModel& model, const Eigen::Vector2d& target, Eigen::Vector2d p, int most_steps,
                                                Eigen::Matrix2d* jacobian) {
    const double tolerance = 1e-10 / std::max(model.fx, model.fy);
    const auto invertible = [&](const Eigen::Vector2d& at, Eigen::Matrix2d& bend, Eigen::Vector2d& miss) {
        miss = distort(model, at, &bend) - target;
        return bend.determinant() > 0 && at.squaredNorm() < model.max_radius_squared;
    };
    Eigen::Matrix2d bend;
    Eigen::Vector2d miss;
    if (!invertible(p, bend, miss)) return std::nullopt;
    for (int i = 0; i < most_steps; ++i) {
        if (miss.cwiseAbs().maxCoeff() <= tolerance) {
            if (jacobian) *jacobian = bend.inverse() * Eigen::Vector2d(1 / model.fx, 1 / model.fy).asDiagonal();
            return p;
        }
        Eigen::Vector2d step = bend.inverse() * miss;
        for (int halved = 0; !invertible(p - step, bend, miss); ++halved, step *= 0.5) {
            if (halved == 20) return std::nullopt;
        }
        p -= step;
    }
    return std::nullopt;
}

/// The same without a grid.
std::optional<Eigen::Vector2d> unproject_ideal(const CameraModel& model, const Eigen::Vector2d& pixel, Eigen::Matrix2d* jacobian) {
    const Eigen::Vector2d target = without_focal(model, pixel);
    const double distorted_radius = target.norm();
    if (!std::isfinite(distorted_radius)) return std::nullopt;
    const auto radius = invert_radius(model, distorted_radius);
    if (!radius) return std::nullopt;
    // The radial part is inverted; Newton adds the tangential part.
    constexpr int enough = 30;
    return newton_unproject(model, target, distorted_radius > 0 ? Eigen::Vector2d(target * (*radius / distorted_radius)) : target, enough, jacobian);
}

}  // namespace

std::optional<Eigen::Vector2d> unproject(const CameraModel& model, const Eigen::Vector2d& pixel, Eigen::Matrix2d* jacobian) {
    if (!model.grid) return unproject_ideal(model, pixel, jacobian);
    Eigen::Matrix2d by_pixel;
    const auto ideal = model.grid->corrected(pixel, &by_pixel);
    const auto ray = ideal ? unproject_ideal(model, *ideal, jacobian) : std::nullopt;
    if (ray && jacobian) *jacobian = (*jacobian * by_pixel).eval();
    return ray;
}

std::optional<Eigen::Vector2d> unproject_beside(const CameraModel& model, const Eigen::Vector2d& pixel, const std::optional<Eigen::Vector2d>& neighbour) {
    constexpr int few = 5;
    if (!model.grid && neighbour) {
        const Eigen::Vector2d target = without_focal(model, pixel);
        if (const auto ray = newton_unproject(model, target, *neighbour, few, nullptr)) return ray;
    }
    return unproject(model, pixel);
}

std::optional<CameraModel> rescaled(const CameraModel& model, int width, int height) {
    const double across = static_cast<double>(width) / model.width, down = static_cast<double>(height) / model.height;
    // Sizes are whole pixels: a picture of half the size may have lost a half.
    if (model.grid || !(across > 0) || std::abs(across - down) * std::max(model.width, model.height) > 1.5 * std::max(across, 1.0)) return std::nullopt;
    CameraModel scaled = model;
    scaled.width = width;
    scaled.height = height;
    scaled.fx *= across;
    scaled.fy *= down;
    // Pixels are squares: their edges scale, not their centres.
    scaled.cx = (model.cx + 0.5) * across - 0.5;
    scaled.cy = (model.cy + 0.5) * down - 0.5;
    return scaled;
}

}  // namespace roomfix
