#include "roomfix/calibrate/plumb_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/levenberg_marquardt.hpp"
#include "roomfix/base/median.hpp"
#include "roomfix/calibrate/straightness.hpp"

namespace roomfix {
namespace {

constexpr int unknowns = 6;
constexpr std::array<int, unknowns> numbers = {2, 3, 4, 5, 6, 7};  // cx, cy, k1, k2, p1, p2 among the intrinsics
using Vector = Eigen::Matrix<double, unknowns, 1>;
using Matrix = Eigen::Matrix<double, unknowns, unknowns>;

CameraModel with(const CameraModel& model, const Vector& change) {
    CameraModel other = model;
    IntrinsicsVector all = model.intrinsics();
    for (int k = 0; k < unknowns; ++k) all[numbers[static_cast<std::size_t>(k)]] += change[k];
    other.set_intrinsics(all);
    return other;
}

/// How far an edge's points are off its line, and how that goes with the lens; the line is fitted anew for each.
struct Linearised {
    Eigen::VectorXd off;  // px
    Eigen::Matrix<double, Eigen::Dynamic, unknowns> by;
};

Linearised linearise(const CameraModel& model, const LongEdge& edge) {
    const Vector step = (Vector() << 0.01, 0.01, 1e-5, 1e-5, 1e-6, 1e-6).finished();
    Linearised at{crookedness(model, edge), {}};
    at.by.resize(at.off.size(), unknowns);
    for (int k = 0; k < unknowns; ++k) {
        at.by.col(k) = (crookedness(with(model, step[k] * Vector::Unit(k)), edge) - crookedness(with(model, -step[k] * Vector::Unit(k)), edge)) / (2 * step[k]);
    }
    // A point that has a ray on one side of the step only tells nothing.
    for (Eigen::Index i = 0; i < at.by.rows(); ++i) {
        if (at.by.row(i).cwiseProduct(step.transpose()).cwiseAbs().maxCoeff() > 0.5) at.by.row(i).setZero();
    }
    return at;
}

double rms_of(const CameraModel& model, const LongEdge& edge) {
    return std::sqrt(crookedness(model, edge).squaredNorm() / static_cast<double>(edge.points.size()));
}

/// The lens with two numbers, out of many, with which most edges are about straight: those that are bent in truth must not lead.
CameraModel first_lens(const CameraModel& given, const std::vector<LongEdge>& edges) {
    constexpr double crooked = 0.5;  // px rms: worse is all the same
    std::vector<LongEdge> thinned;
    for (const LongEdge& edge : edges) {
        thinned.emplace_back();
        for (std::size_t i = 0; i < edge.points.size(); i += 6) thinned.back().points.push_back(edge.points[i]);
    }
    CameraModel best = given;
    double least = 1e300;
    for (double k1 = -0.60; k1 < 0.401; k1 += 0.04) {
        for (double k2 = -0.20; k2 < 0.401; k2 += 0.05) {
            CameraModel tried = given;
            IntrinsicsVector all = IntrinsicsVector::Zero();
            all.head<4>() = given.intrinsics().head<4>();
            all[4] = k1;
            all[5] = k2;
            tried.set_intrinsics(all);
            double cost = 0;
            for (const LongEdge& edge : thinned)
                cost += static_cast<double>(edge.points.size()) * std::min(std::pow(rms_of(tried, edge), 2), crooked * crooked);
            if (cost >= least) continue;
            least = cost;
            best = tried;
        }
    }
    return best;
}

std::size_t count_used(const std::vector<LongEdge>& edges) {
    return static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), [](const LongEdge& e) { return e.used; }));
}

/// What is known of the image centre, p1 and p2 before anything is seen.
class Prior {
public:
    Prior(const CameraModel& start, const PlumbLineSettings& settings) : centre_(start.cx, start.cy) {
        const double centre = std::pow(settings.centre_sigma * start.width, -2), tangential = std::pow(settings.tangential_sigma, -2);
        weight_ << centre, centre, 0, 0, tangential, tangential;
    }
    Matrix information() const { return weight_.asDiagonal(); }
    Vector gradient(const CameraModel& m) const { return weight_.cwiseProduct(off(m)); }
    double cost(const CameraModel& m) const { return off(m).dot(gradient(m)); }

private:
    Vector off(const CameraModel& m) const { return (Vector() << m.cx - centre_.x(), m.cy - centre_.y(), 0, 0, m.distortion[2], m.distortion[3]).finished(); }
    Eigen::Vector2d centre_;
    Vector weight_;
};

/// The square of a standard normal number is cut off at `most`; its mean then.
double mean_of_cut_square(double most) {
    const double limit = std::sqrt(most), outside = std::erfc(limit / std::sqrt(2.0));
    constexpr double two_densities = 0.7978845608028654;  // 2 / sqrt(2 pi)
    return 1 - outside - two_densities * limit * std::exp(-0.5 * most) + most * outside;
}

/// Lens, noise, and which edges are straight.
class StraightLens {
public:
    StraightLens(CameraModel model, std::vector<LongEdge>& edges, const Prior& prior, double outlier)
        : model_(std::move(model)), edges_(edges), prior_(prior), outlier_(outlier) {
        for (const LongEdge& edge : edges) shapes_.emplace_back(edge);
        leave_out_crooked(2 * outlier);
    }

    const CameraModel& model() const { return model_; }
    Matrix covariance() const { return (at_.information + prior_.information()).inverse(); }

    /// Levenberg-Marquardt over the edges that are used.
    void minimise() {
        at_ = sum_of(model_);
        levenberg_marquardt({.start = 1e-4, .rounds = 40}, [this](double damping) {
            const Matrix information = at_.information + prior_.information();
            const Vector gradient = at_.gradient + prior_.gradient(model_);
            const CameraModel next = with(model_, -damped_step(information, gradient, damping));
            Sum tried = sum_of(next);
            const double before = at_.squares + prior_.cost(model_), after = tried.squares + prior_.cost(next);
            if (!(after <= before)) return StepResult::worse;
            model_ = next;
            at_ = std::move(tried);
            return before - after < 1e-9 * before ? StepResult::settled : StepResult::better;
        });
    }

    /// Learns the noise from the edges that are used, and chooses those that are as straight as it says. True if either has changed.
    bool look_again() {
        bends_.clear();
        const EdgeNoise before = noise_;
        learn_points();
        for (std::size_t i = 0; i < edges_.size(); ++i) bends_.push_back(bend_of(i));
        learn_bend();
        const bool chosen = leave_out_crooked(outlier_);
        const auto same = [](double a, double b) { return std::abs(a - b) < 0.01 * (a + b) + 1e-8; };
        return chosen || !same(before.point, noise_.point) || !same(before.bend, noise_.bend);
    }

private:
    struct Sum {
        Matrix information = Matrix::Zero();
        Vector gradient = Vector::Zero();
        double squares = 0;
    };
    /// An edge's bow and S: px, and the part of their variances (px^2) that the points and the lens leave. The lens has followed edges that are used.
    struct Bend {
        std::array<double, EdgeShape::bends> off, variance;
    };

    Sum sum_of(const CameraModel& model) const {
        Sum sum;
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            if (!edges_[i].used) continue;
            const Linearised edge = linearise(model, edges_[i]);
            const Eigen::MatrixXd by = shapes_[i].weighed(edge.by, noise_);
            const Eigen::VectorXd off = shapes_[i].weighed(edge.off, noise_);
            sum.information += edge.by.transpose() * by;
            sum.gradient += edge.by.transpose() * off;
            sum.squares += edge.off.dot(off);
        }
        return sum;
    }

    void learn_points() {
        double squares = 0, count = 0;
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            if (!edges_[i].used) continue;
            const Eigen::VectorXd all = shapes_[i].coefficients(crookedness(model_, edges_[i]));
            for (int k = EdgeShape::bow + EdgeShape::bends; k < shapes_[i].orders(); ++k) {
                squares += all[k] * all[k] / shapes_[i].variance(k);
                ++count;
            }
        }
        if (count > 0) noise_.point = std::max(squares / count, least_point);
    }

    Bend bend_of(std::size_t i) const {
        const Linearised edge = linearise(model_, edges_[i]);
        const Eigen::VectorXd off = shapes_[i].coefficients(edge.off);
        const Eigen::MatrixXd by = shapes_[i].coefficients(edge.by);
        const Matrix lens = covariance();
        Bend bend;
        for (std::size_t k = 0; k < bend.off.size(); ++k) {
            const int order = EdgeShape::bow + static_cast<int>(k);
            const double by_lens = by.row(order).dot(lens * by.row(order).transpose());
            const double own = shapes_[i].variance(order) * noise_.point;
            bend.off[k] = off[order];
            bend.variance[k] = std::max(own + (edges_[i].used ? -by_lens : by_lens), 0.1 * own);
        }
        return bend;
    }

    static double normalised(const Bend& bend, std::size_t k, double bend_variance) { return bend.off[k] * bend.off[k] / (bend.variance[k] + bend_variance); }

    /// The variance with which bends of used edges are as large as they should be; single wild ones do not lead.
    void learn_bend() {
        const double most = outlier_ * outlier_;
        const auto excess = [&](double variance) {
            double sum = 0;
            for (std::size_t i = 0; i < edges_.size(); ++i) {
                if (!edges_[i].used) continue;
                for (std::size_t k = 0; k < EdgeShape::bends; ++k) sum += std::min(normalised(bends_[i], k, variance), most) - mean_of_cut_square(most);
            }
            return sum;
        };
        double low = 0, high = 1;  // px^2
        if (excess(low) <= 0) {
            noise_.bend = 0;
            return;
        }
        for (int round = 0; round < 40; ++round) {
            const double middle = 0.5 * (low + high);
            (excess(middle) > 0 ? low : high) = middle;
        }
        noise_.bend = high;
    }

    /// True if that changed the choice.
    bool leave_out_crooked(double times) {
        std::vector<double> all;
        for (const LongEdge& edge : edges_) all.push_back(rms_of(model_, edge));
        std::vector<double> sorted = all;
        const double limit = times * std::max(median(sorted), 0.05);
        bool changed = false;
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            bool good = all[i] <= limit;
            for (std::size_t k = 0; k < EdgeShape::bends && !bends_.empty(); ++k) good = good && normalised(bends_[i], k, noise_.bend) < times * times;
            changed = changed || good != edges_[i].used;
            edges_[i].used = good;
        }
        return changed;
    }

    static constexpr double least_point = 1e-4;  // px^2

    CameraModel model_;
    std::vector<LongEdge>& edges_;
    std::vector<EdgeShape> shapes_;
    std::vector<Bend> bends_;
    const Prior& prior_;
    double outlier_;
    EdgeNoise noise_;
    Sum at_;
};

/// Root mean square over all points of the used edges, px.
double rms_of_used(const CameraModel& model, const std::vector<LongEdge>& edges) {
    double squares = 0, points = 0;
    for (const LongEdge& edge : edges) {
        if (!edge.used) continue;
        squares += crookedness(model, edge).squaredNorm();
        points += static_cast<double>(edge.points.size());
    }
    return std::sqrt(squares / std::max(points, 1.0));
}

/// px by which k1's error moves the picture's corner.
double error_at_corner(const CameraModel& model, double k1_sigma) {
    const Eigen::Vector2d half(0.5 * model.width, 0.5 * model.height);
    return k1_sigma * (half.x() * half.x() / (model.fx * model.fx) + half.y() * half.y() / (model.fy * model.fy)) * half.norm();
}

}  // namespace

Result<PlumbLine> straighten(std::vector<LongEdge> all, const CameraModel& start, const PlumbLineSettings& settings) {
    const auto too_few = [&](std::size_t count) {
        return Error{
            fmt::format("{} long edges that can be straight, {} or more are needed: take pictures with door frames, skirtings and ceiling edges all over",
                        count, settings.least_lines)};
    };
    if (start.kind != Distortion::plumb_bob) {
        return Error{fmt::format("the camera's lens is of the kind {}: straight lines are made straight for plumb_bob only; use a board", name_of(start.kind))};
    }
    std::erase_if(all, [](const LongEdge& e) { return e.points.size() < least_edge_points; });
    PlumbLine result;
    result.edges = without_repeats(std::move(all));
    std::vector<LongEdge>& edges = result.edges;
    if (edges.size() < settings.least_lines) return too_few(edges.size());
    const Prior prior(start, settings);
    StraightLens lens(first_lens(make_camera_model(start.width, start.height, start.fx, start.fy, start.cx, start.cy), edges), edges, prior, settings.outlier);
    constexpr int rounds = 20;
    for (int round = 0; round < rounds; ++round) {
        if (count_used(edges) < settings.least_lines) return too_few(count_used(edges));
        lens.minimise();
        if (round + 1 == rounds || !lens.look_again()) break;
    }
    result.model = lens.model();
    const Matrix covariance = lens.covariance();
    for (int i = 0; i < unknowns; ++i) {
        for (int k = 0; k < unknowns; ++k) result.covariance(numbers[static_cast<std::size_t>(i)], numbers[static_cast<std::size_t>(k)]) = covariance(i, k);
    }
    constexpr double most = 0.05;  // of the picture's width
    if (!(error_at_corner(start, std::sqrt(covariance(2, 2))) < most * start.width)) {
        return Error{"these edges do not fix the lens: they must run along the picture's border, too, not only through its middle"};
    }
    result.used = static_cast<int>(count_used(edges));
    result.rms = rms_of_used(result.model, edges);
    result.before = rms_of_used(start, edges);
    return result;
}

IntrinsicsMatrix covariance_with_focal(const PlumbLine& found, const IntrinsicsMatrix& known) {
    // Powers of the focal length by which k1, k2, p1 and p2 grow.
    const std::array<int, 4> powers = {2, 4, 1, 1};
    Eigen::Matrix<double, most_intrinsics, 2> by_focal = Eigen::Matrix<double, most_intrinsics, 2>::Zero();
    by_focal(0, 0) = by_focal(1, 1) = 1;
    for (Eigen::Index i = 0; i < 4; ++i) {
        const double bending = powers[static_cast<std::size_t>(i)] * found.model.distortion[static_cast<std::size_t>(i)];
        by_focal.row(4 + i) << 0.5 * bending / found.model.fx, 0.5 * bending / found.model.fy;
    }
    return found.covariance + by_focal * known.topLeftCorner<2, 2>() * by_focal.transpose();
}

}  // namespace roomfix
