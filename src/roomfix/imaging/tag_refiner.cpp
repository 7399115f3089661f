#include "roomfix/imaging/tag_refiner.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/levenberg_marquardt.hpp"

namespace roomfix {
namespace {

// The unknowns: eight of the homography from the tag (bits) to rays; the blur, and by how much white outgrows black (in blurs: bright pictures bleed, ink
// spreads), both across the tag and down; and the light: dark and the way from dark to bright, each with its slopes.
constexpr int blur_at = 8, growth_at = 10, light_at = 12, tag_unknowns = 18;
using Unknowns = Eigen::Matrix<double, tag_unknowns, 1>;
using Normal = Eigen::Matrix<double, tag_unknowns, tag_unknowns>;
using ByHomography = Eigen::Matrix<double, 2, 8>;

struct LitPixel {
    Eigen::Vector2d ray;
    double grey;
};

double phi(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }
double density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi); }

/// How much each of the five cells around a place counts after blur along one axis, with its derivatives.
struct Share {
    int first = 0;
    std::array<double, 5> value{}, by_place{}, by_sigma{};

    Share(double place, double sigma) : first(static_cast<int>(std::floor(place)) - 2) {
        double phi_before = 0, density_before = 0, z_before = 0;
        for (int i = 0; i <= 5; ++i) {
            const double z = (first + i - place) / sigma;
            const double phi_here = phi(z), density_here = density(z);
            if (i > 0) {
                const auto k = static_cast<std::size_t>(i - 1);
                value[k] = phi_here - phi_before;
                by_place[k] = -(density_here - density_before) / sigma;
                by_sigma[k] = -(z * density_here - z_before * density_before) / sigma;
            }
            phi_before = phi_here;
            density_before = density_here;
            z_before = z;
        }
    }
};

/// Of the normal distribution: a rational start (Abramowitz and Stegun 26.2.23) and one of Halley's steps.
double quantile(double p) {
    const double t = std::sqrt(-2 * std::log(std::min(p, 1 - p)));
    const double upper = t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
    const double z = p < 0.5 ? -upper : upper;
    const double step = (phi(z) - p) / density(z);
    return z - step / (1 + 0.5 * z * step);
}

/// All borders between black and white moved: exact for straight ones.
struct Grown {
    double white, by_white, by_growth;

    Grown(double blurred, double growth) {
        constexpr double edge = 1e-4;
        const double z = quantile(std::clamp(blurred, edge, 1 - edge));
        white = phi(z + growth);
        by_growth = density(z + growth);
        by_white = by_growth / density(z);
    }
};

/// The printed pattern as a lens blurs it: 0 black, 1 white.
struct Pattern {
    double white = 0;
    double by_u = 0, by_v = 0, by_sigma_u = 0, by_sigma_v = 0;

    Pattern(const LumaImage& bits, const Eigen::Vector2d& at, const Eigen::Vector2d& sigma) {
        const Share across(at.x(), sigma.x()), down(at.y(), sigma.y());
        for (int r = 0; r < 5; ++r) {
            const int row = std::clamp(down.first + r, 0, bits.height() - 1);
            const auto i = static_cast<std::size_t>(r);
            for (int c = 0; c < 5; ++c) {
                const int column = std::clamp(across.first + c, 0, bits.width() - 1);
                if (bits.row(row)[column] < 128) continue;
                const auto k = static_cast<std::size_t>(c);
                white += across.value[k] * down.value[i];
                by_u += across.by_place[k] * down.value[i];
                by_v += across.value[k] * down.by_place[i];
                by_sigma_u += across.by_sigma[k] * down.value[i];
                by_sigma_v += across.value[k] * down.by_sigma[i];
            }
        }
    }
};

Eigen::Matrix3d homography_of(const Unknowns& x) {
    Eigen::Matrix3d h;
    h << x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], 1;
    return h;
}

/// Where a place on the tag (bits) is seen, as a ray, with its derivatives by the homography and the place.
Eigen::Vector2d ray_of(const Eigen::Matrix3d& h, const Eigen::Vector2d& place, ByHomography* by_h = nullptr, Eigen::Matrix2d* by_place = nullptr) {
    const Eigen::Vector3d q = place.homogeneous();
    const Eigen::Vector3d p = h * q;
    const Eigen::Vector2d ray = p.hnormalized();
    if (by_h != nullptr) {
        by_h->setZero();
        by_h->block<1, 3>(0, 0) = q.transpose() / p.z();
        by_h->block<1, 3>(1, 3) = q.transpose() / p.z();
        by_h->block<2, 2>(0, 6) = -ray * q.head<2>().transpose() / p.z();
    }
    if (by_place != nullptr) *by_place = (h.topLeftCorner<2, 2>() - ray * h.block<1, 2>(2, 0)) / p.z();
    return ray;
}

/// The corners on the tag in bits, in the order of SeenTag.
std::array<Eigen::Vector2d, 4> corners_on(const TagPicture& picture) {
    const double from = 0.5 * (picture.bits.width() - picture.square), to = from + picture.square;
    return {Eigen::Vector2d(from, to), {to, to}, {to, from}, {from, from}};
}

class Refiner {
public:
    Refiner(const TagPicture& picture, const TagRefinerSettings& settings) : bits_(picture.bits), corners_(corners_on(picture)), settings_(settings) {}

    bool start(LumaView frame, const CameraModel& model, const SeenTag& seen);
    bool solve();
    std::optional<SeenTag> result(const CameraModel& model, const SeenTag& seen) const;

private:
    struct Linearised {
        Normal information = Normal::Zero();
        Unknowns gradient = Unknowns::Zero();
        double squares = 0;
        int pixels = 0;
    };
    Linearised linearise(const Unknowns& x) const;
    void collect(LumaView frame, const CameraModel& model);
    double contrast() const { return x_[light_at + 3]; }

    const LumaImage& bits_;
    std::array<Eigen::Vector2d, 4> corners_;
    TagRefinerSettings settings_;
    Unknowns x_ = Unknowns::Zero();
    Eigen::Vector2d bits_per_pixel_ = Eigen::Vector2d::Ones();  // along the tag's own axes, at its middle
    std::vector<LitPixel> pixels_;
    Linearised at_;
};

bool Refiner::start(LumaView frame, const CameraModel& model, const SeenTag& seen) {
    Eigen::Matrix<double, 8, 8> a = Eigen::Matrix<double, 8, 8>::Zero();
    Eigen::Matrix<double, 8, 1> b;
    for (int i = 0; i < 4; ++i) {
        const auto ray = unproject(model, seen.corners[static_cast<std::size_t>(i)]);
        if (!ray) return false;
        const Eigen::Vector3d q = corners_[static_cast<std::size_t>(i)].homogeneous();
        a.block<1, 3>(2 * i, 0) = q.transpose();
        a.block<1, 3>(2 * i + 1, 3) = q.transpose();
        a.block<1, 2>(2 * i, 6) = -ray->x() * q.head<2>().transpose();
        a.block<1, 2>(2 * i + 1, 6) = -ray->y() * q.head<2>().transpose();
        b.segment<2>(2 * i) = *ray;
    }
    const Eigen::FullPivLU<Eigen::Matrix<double, 8, 8>> solver(a);
    if (!solver.isInvertible()) return false;
    x_.head<8>() = solver.solve(b);
    const Eigen::Vector2d middle(0.5 * bits_.width(), 0.5 * bits_.height());
    Eigen::Matrix2d ray_by_place, ray_by_pixel;
    const Eigen::Vector2d ray = ray_of(homography_of(x_), middle, nullptr, &ray_by_place);
    const auto pixel = project(model, ray.homogeneous());
    if (!pixel || !unproject(model, *pixel, &ray_by_pixel)) return false;
    const Eigen::Matrix2d place_by_pixel = ray_by_place.inverse() * ray_by_pixel;
    if (!place_by_pixel.allFinite()) return false;
    bits_per_pixel_ = place_by_pixel.rowwise().norm();
    x_.segment<2>(blur_at).setConstant(settings_.start_blur);
    collect(frame, model);
    if (pixels_.size() < 4 * tag_unknowns) return false;
    std::vector<double> greys;
    for (const LitPixel& p : pixels_) greys.push_back(p.grey);
    std::sort(greys.begin(), greys.end());
    x_[light_at] = greys[greys.size() / 20];
    x_[light_at + 3] = greys[greys.size() - 1 - greys.size() / 20] - x_[light_at];
    return contrast() > settings_.least_contrast;
}

/// The pixels along borders of black and white, and some of the plain ones; none at the outer border, beyond which nobody knows what is. Every pixel
/// counts where it counts: every second one would see but one of the fields or colours that a camera makes its pictures of.
void Refiner::collect(LumaView frame, const CameraModel& model) {
    constexpr double plain = 0.02;
    const Eigen::Matrix3d h = homography_of(x_);
    const double size = bits_.width();
    Eigen::AlignedBox2d box;
    for (const auto& [u, v] : {std::pair{0.0, 0.0}, {size, 0.0}, {size, size}, {0.0, size}}) {
        const auto pixel = project(model, ray_of(h, {u, v}).homogeneous());
        if (pixel) box.extend(*pixel);
    }
    if (box.isEmpty()) return;
    const int left = std::max(static_cast<int>(box.min().x()), 0), right = std::min(static_cast<int>(box.max().x()) + 1, frame.width - 1);
    const int top = std::max(static_cast<int>(box.min().y()), 0), bottom = std::min(static_cast<int>(box.max().y()) + 1, frame.height - 1);
    const Eigen::Matrix3d back = h.inverse();
    const double margin = std::min(0.5, 8 * settings_.start_blur * bits_per_pixel_.maxCoeff());
    const Eigen::Vector2d wide = settings_.capture * bits_per_pixel_;
    for (int y = top; y <= bottom; ++y) {
        for (int x = left; x <= right; ++x) {
            const auto ray = unproject(model, {x, y});
            if (!ray) continue;
            const Eigen::Vector2d place = (back * ray->homogeneous()).hnormalized();
            if (place.minCoeff() < margin || place.maxCoeff() > size - margin) continue;
            const double white = Pattern(bits_, place, wide).white;
            const bool at_border = white > plain && white < 1 - plain;
            if (at_border || (7 * x + 11 * y) % settings_.plain_step == 0) pixels_.push_back({*ray, static_cast<double>(frame.at(x, y))});
        }
    }
}

Refiner::Linearised Refiner::linearise(const Unknowns& x) const {
    Linearised l;
    const Eigen::Matrix3d h = homography_of(x);
    const Eigen::Matrix3d back = h.inverse();
    const Eigen::Vector2d sigma = x.segment<2>(blur_at).cwiseProduct(bits_per_pixel_);
    const double middle = 0.5 * bits_.width();
    for (const LitPixel& p : pixels_) {
        const Eigen::Vector2d place = (back * p.ray.homogeneous()).hnormalized();
        ByHomography by_h;
        Eigen::Matrix2d by_place;
        ray_of(h, place, &by_h, &by_place);
        const Pattern pattern(bits_, place, sigma);
        const Eigen::Vector3d shape(1, (place.x() - middle) / middle, (place.y() - middle) / middle);
        const double bright = x.segment<3>(light_at + 3).dot(shape);
        // Upright borders grow across, level ones down.
        const double across = std::pow(pattern.by_u * sigma.x(), 2) + 1e-12, down = std::pow(pattern.by_v * sigma.y(), 2) + 1e-12;
        const Eigen::Vector2d part = Eigen::Vector2d(across, down) / (across + down);
        const Grown grown(pattern.white, x.segment<2>(growth_at).dot(part));
        const double residual = p.grey - x.segment<3>(light_at).dot(shape) - bright * grown.white;
        // The ray stays: where the homography moves it, the place on the tag moves back.
        const Eigen::RowVector2d by_ray = -bright * grown.by_white * Eigen::RowVector2d(pattern.by_u, pattern.by_v) * by_place.inverse();
        Unknowns j;
        j.head<8>() = (by_ray * by_h).transpose();
        j[blur_at] = bright * grown.by_white * pattern.by_sigma_u * bits_per_pixel_.x();
        j[blur_at + 1] = bright * grown.by_white * pattern.by_sigma_v * bits_per_pixel_.y();
        j.segment<2>(growth_at) = bright * grown.by_growth * part;
        j.segment<3>(light_at) = shape;
        j.segment<3>(light_at + 3) = grown.white * shape;
        l.information.selfadjointView<Eigen::Lower>().rankUpdate(j);
        l.gradient += residual * j;
        l.squares += residual * residual;
        ++l.pixels;
    }
    l.information = l.information.selfadjointView<Eigen::Lower>();
    return l;
}

bool Refiner::solve() {
    constexpr double most_growth = 1.5;  // blurs
    at_ = linearise(x_);
    const bool possible = levenberg_marquardt({.most = 1e7, .rounds = settings_.most_rounds}, [&](double damping) {
        const Unknowns step = damped_step(at_.information, at_.gradient, damping);
        if (!step.allFinite()) return StepResult::impossible;
        Unknowns moved = x_ + step;
        for (int i = 0; i < 2; ++i) {
            moved[blur_at + i] = std::clamp(moved[blur_at + i], settings_.least_blur, settings_.widest_blur);
            moved[growth_at + i] = std::clamp(moved[growth_at + i], -most_growth, most_growth);
        }
        const Linearised next = linearise(moved);
        if (!(next.squares < at_.squares)) return StepResult::worse;
        const bool settled = at_.squares - next.squares < 1e-7 * at_.squares;
        x_ = moved;
        at_ = next;
        return settled ? StepResult::settled : StepResult::better;
    });
    if (!possible) return false;
    const double rms = std::sqrt(at_.squares / std::max(at_.pixels - tag_unknowns, 1));
    return contrast() > settings_.least_contrast && rms < settings_.largest_misfit * contrast();
}

std::optional<SeenTag> Refiner::result(const CameraModel& model, const SeenTag& seen) const {
    const Eigen::LLT<Normal> factor(at_.information);
    if (factor.info() != Eigen::Success) return std::nullopt;
    const double variance = settings_.alike_residuals * at_.squares / std::max(at_.pixels - tag_unknowns, 1);
    const Eigen::Matrix<double, 8, 8> of_homography = variance * Normal(factor.solve(Normal::Identity())).topLeftCorner<8, 8>();
    SeenTag refined = seen;
    Eigen::Matrix<double, 8, 8> by_h;
    const double edge = (seen.corners[0] - seen.corners[2]).norm() / std::numbers::sqrt2;
    // The corners are where black and white meet, however far white has bled.
    const Eigen::Vector2d middle(0.5 * bits_.width(), 0.5 * bits_.height());
    const int inside = static_cast<int>(corners_[3].x());
    const double bled = bits_.row(inside)[inside] > 127 ? 1 : -1;
    const Eigen::Vector2d growth = x_.segment<2>(growth_at).cwiseProduct(x_.segment<2>(blur_at)).cwiseProduct(bits_per_pixel_);
    const double most_moved = settings_.most_moved + settings_.most_moved_part * edge;
    for (int i = 0; i < 4; ++i) {
        const auto k = static_cast<std::size_t>(i);
        ByHomography ray_by_h;
        const Eigen::Vector2d ray = ray_of(homography_of(x_), corners_[k] + bled * (corners_[k] - middle).cwiseSign().cwiseProduct(growth), &ray_by_h);
        ProjectionJacobian by_point;
        const auto pixel = project(model, ray.homogeneous(), &by_point);
        if (!pixel || !((*pixel - seen.corners[k]).norm() < most_moved)) return std::nullopt;
        refined.corners[k] = *pixel;
        by_h.middleRows<2>(2 * i) = by_point.leftCols<2>() * ray_by_h;
    }
    refined.covariance = by_h * of_homography * by_h.transpose();
    refined.covariance.diagonal().array() += settings_.floor_sigma * settings_.floor_sigma;
    if (!refined.covariance.allFinite()) return std::nullopt;
    return refined;
}

}  // namespace

std::optional<SeenTag> refine_tag(LumaView frame, const CameraModel& model, const SeenTag& seen, const TagPicture& picture,
                                  const TagRefinerSettings& settings) {
    Refiner refiner(picture, settings);
    if (!refiner.start(frame, model, seen) || !refiner.solve()) return std::nullopt;
    return refiner.result(model, seen);
}

}  // namespace roomfix
