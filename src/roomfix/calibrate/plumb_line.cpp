#include "roomfix/calibrate/plumb_line.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "roomfix/imaging/edge_points.hpp"

namespace roomfix {
namespace {

Eigen::Vector2d place_of(const EdgePoint& p) { return {p.x, p.y}; }
Eigen::Vector2d normal_of(const EdgePoint& p) { return {p.nx, p.ny}; }

/// Edge points by the cell of 2 x 2 px that they are in.
class PointMap {
public:
    explicit PointMap(const std::vector<EdgePoint>& points) : points_(points) {
        for (std::size_t i = 0; i < points.size(); ++i) cells_[cell(place_of(points[i]))].push_back(i);
    }
    /// The point nearest to a place, within `reach` px, with about this normal, that is still free.
    std::optional<std::size_t> nearest(const Eigen::Vector2d& place, const Eigen::Vector2d& normal, double reach, const std::vector<char>& taken) const {
        constexpr double same_direction = 0.94;
        std::optional<std::size_t> best;
        double least = reach;
        const int steps = static_cast<int>(std::ceil(reach / size));
        for (int dy = -steps; dy <= steps; ++dy) {
            for (int dx = -steps; dx <= steps; ++dx) {
                const auto in = cells_.find(cell(place + size * Eigen::Vector2d(dx, dy)));
                if (in == cells_.end()) continue;
                for (const std::size_t i : in->second) {
                    const EdgePoint& p = points_[i];
                    if (taken[i] || normal_of(p).dot(normal) < same_direction) continue;
                    const double distance = (place_of(p) - place).norm();
                    if (distance >= least) continue;
                    least = distance;
                    best = i;
                }
            }
        }
        return best;
    }

private:
    static constexpr double size = 2;  // px
    static std::pair<int, int> cell(const Eigen::Vector2d& p) {
        return {static_cast<int>(std::floor(p.x() / size)), static_cast<int>(std::floor(p.y() / size))};
    }
    const std::vector<EdgePoint>& points_;
    std::map<std::pair<int, int>, std::vector<std::size_t>> cells_;
};

/// Follows the edge from a point, to the left of its brighter side (sign 1) or to the right.
std::vector<std::size_t> follow(const std::vector<EdgePoint>& points, const PointMap& map, std::size_t from, double sign, std::vector<char>& taken) {
    constexpr double step = 1.6, reach = 1.3;  // px
    std::vector<std::size_t> chain;
    Eigen::Vector2d at = place_of(points[from]);
    Eigen::Vector2d normal = normal_of(points[from]);
    for (int missed = 0; missed < 3;) {
        const Eigen::Vector2d along = sign * Eigen::Vector2d(-normal.y(), normal.x());
        const Eigen::Vector2d expected = at + step * along;
        const auto next = map.nearest(expected, normal, reach, taken);
        if (!next) {
            at = expected;
            ++missed;
            continue;
        }
        missed = 0;
        taken[*next] = 1;
        chain.push_back(*next);
        at = place_of(points[*next]);
        // Its own direction is noisy; that of the last stretch is not.
        constexpr std::size_t stretch = 8;
        normal = (0.85 * normal + 0.15 * normal_of(points[*next])).normalized();
        if (chain.size() > stretch) {
            const Eigen::Vector2d way = (at - place_of(points[chain[chain.size() - 1 - stretch]])).normalized() * sign;
            normal = (normal + Eigen::Vector2d(way.y(), -way.x())).normalized();
        }
    }
    return chain;
}

double length_of(const LongEdge& edge) { return (edge.points.back() - edge.points.front()).norm(); }

/// Angle between the directions of the first and the last third.
double turn_of(const LongEdge& edge) {
    const std::size_t third = edge.points.size() / 3;
    const Eigen::Vector2d a = edge.points[third] - edge.points.front(), b = edge.points.back() - edge.points[edge.points.size() - 1 - third];
    return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
}

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

/// How far each point of an edge is off the straight line that fits the edge best without distortion; px of the picture. Points for which the
/// model has no rays are far off, for whatever line.
Eigen::VectorXd crookedness(const CameraModel& model, const LongEdge& edge) {
    constexpr double no_ray = 3;  // px
    const auto count = static_cast<Eigen::Index>(edge.points.size());
    Eigen::Matrix<double, 2, Eigen::Dynamic> rays(2, count);
    std::vector<Eigen::Matrix2d> by_pixel(edge.points.size());
    std::vector<Eigen::Index> known;
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto ray = unproject(model, edge.points[static_cast<std::size_t>(i)], &by_pixel[static_cast<std::size_t>(i)]);
        if (!ray) continue;
        rays.col(i) = *ray;
        known.push_back(i);
    }
    Eigen::VectorXd off = Eigen::VectorXd::Constant(count, no_ray);
    if (known.size() < 3) return off;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const Eigen::Index i : known) middle += rays.col(i) / static_cast<double>(known.size());
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const Eigen::Index i : known) spread += (rays.col(i) - middle) * (rays.col(i) - middle).transpose();
    Eigen::RowVector2d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvectors().col(0).transpose();
    if (normal.x() + 1e-3 * normal.y() < 0) normal = -normal;  // an eigenvector's sign is arbitrary; derivatives need the same one
    for (const Eigen::Index i : known) off[i] = normal.dot(rays.col(i) - middle) / (normal * by_pixel[static_cast<std::size_t>(i)]).norm();
    return off;
}

struct Edges {
    Matrix information = Matrix::Zero();
    Vector gradient = Vector::Zero();
    std::vector<std::pair<Matrix, Vector>> own;  // each edge's part of both
    double squares = 0;
};

/// Normal equations over all edges that are used; derivatives numerically, each edge's line fitted anew.
Edges linearise(const CameraModel& model, const std::vector<LongEdge>& edges) {
    const Vector step = (Vector() << 0.01, 0.01, 1e-5, 1e-5, 1e-6, 1e-6).finished();
    Edges sum;
    for (const LongEdge& edge : edges) {
        if (!edge.used) continue;
        const Eigen::VectorXd off = crookedness(model, edge);
        Eigen::Matrix<double, Eigen::Dynamic, unknowns> by(off.size(), unknowns);
        for (int k = 0; k < unknowns; ++k) {
            by.col(k) =
                (crookedness(with(model, step[k] * Vector::Unit(k)), edge) - crookedness(with(model, -step[k] * Vector::Unit(k)), edge)) / (2 * step[k]);
        }
        // A point that has a ray on one side of the step only tells nothing.
        for (Eigen::Index i = 0; i < by.rows(); ++i) {
            if (by.row(i).cwiseProduct(step.transpose()).cwiseAbs().maxCoeff() > 0.5) by.row(i).setZero();
        }
        sum.own.emplace_back(by.transpose() * by, by.transpose() * off);
        sum.information += sum.own.back().first;
        sum.gradient += sum.own.back().second;
        sum.squares += off.squaredNorm();
    }
    return sum;
}

double rms_of(const CameraModel& model, const LongEdge& edge) {
    return std::sqrt(crookedness(model, edge).squaredNorm() / static_cast<double>(edge.points.size()));
}

/// Chooses the edges that are about as straight as most. True if that changed the choice.
bool choose(const CameraModel& model, std::vector<LongEdge>& edges, double times) {
    std::vector<double> all;
    for (const LongEdge& edge : edges) all.push_back(rms_of(model, edge));
    std::vector<double> sorted = all;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double limit = times * std::max(sorted[sorted.size() / 2], 0.05);
    bool changed = false;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const bool good = all[i] <= limit;
        changed = changed || good != edges[i].used;
        edges[i].used = good;
    }
    return changed;
}

/// The lens with two numbers, out of many, with which most edges are about straight: those that are bent in truth must not lead.
CameraModel first_lens(const CameraModel& given, const std::vector<LongEdge>& edges) {
    constexpr double crooked = 0.5;  // px rms: worse is all the same
    std::vector<LongEdge> thinned;
    for (const LongEdge& edge : edges) {
        thinned.emplace_back();
        for (std::size_t i = 0; i < edge.points.size(); i += 4) thinned.back().points.push_back(edge.points[i]);
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

/// The same edge in several pictures of a camera that stands still says no more than once.
void drop_repeated(std::vector<LongEdge>& edges) {
    constexpr double same = 4;  // px
    const auto covers = [&](const LongEdge& longer, const LongEdge& edge) {
        for (const std::size_t i : {std::size_t{0}, edge.points.size() / 2, edge.points.size() - 1}) {
            const bool near =
                std::any_of(longer.points.begin(), longer.points.end(), [&](const Eigen::Vector2d& p) { return (p - edge.points[i]).norm() < same; });
            if (!near) return false;
        }
        return true;
    };
    std::stable_sort(edges.begin(), edges.end(), [](const LongEdge& a, const LongEdge& b) { return a.points.size() > b.points.size(); });
    std::vector<LongEdge> kept;
    for (LongEdge& edge : edges) {
        const bool known = std::any_of(kept.begin(), kept.end(), [&](const LongEdge& k) { return k.picture != edge.picture && covers(k, edge); });
        if (!known) kept.push_back(std::move(edge));
    }
    edges = std::move(kept);
}

std::size_t count_used(const std::vector<LongEdge>& edges) {
    return static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), [](const LongEdge& e) { return e.used; }));
}

/// What is known of the image centre, p1 and p2 before anything is seen.
class Prior {
public:
    Prior(const CameraModel& start, const PlumbLineSettings& settings) : centre_(start.cx, start.cy) {
        const double centre = std::pow(settings.centre_sigma * start.width, -2), tangential = std::pow(settings.tangential_sigma, -2);
        weight_ = noise * noise * (Vector() << centre, centre, 0, 0, tangential, tangential).finished();
    }
    Vector off(const CameraModel& m) const { return (Vector() << m.cx - centre_.x(), m.cy - centre_.y(), 0, 0, m.distortion[2], m.distortion[3]).finished(); }
    Matrix information() const { return weight_.asDiagonal(); }
    Matrix by_edge() const { return noise * noise * information(); }
    Vector gradient(const CameraModel& m) const { return weight_.cwiseProduct(off(m)); }
    double cost(const CameraModel& m) const { return off(m).dot(gradient(m)); }

private:
    static constexpr double noise = 0.1;  // px, of points: how much the prior weighs beside them
    Eigen::Vector2d centre_;
    Vector weight_;
};

/// Levenberg-Marquardt over the edges that are used.
Edges minimise(CameraModel& model, const std::vector<LongEdge>& edges, const Prior& prior) {
    Edges at = linearise(model, edges);
    double damping = 1e-4;
    for (int round = 0; round < 40 && damping < 1e8; ++round) {
        Matrix damped = at.information + prior.information();
        damped.diagonal() *= 1 + damping;
        const CameraModel next = with(model, -damped.ldlt().solve(at.gradient + prior.gradient(model)));
        Edges tried = linearise(next, edges);
        const double before = at.squares + prior.cost(model), after = tried.squares + prior.cost(next);
        if (!(after <= before)) {
            damping *= 10;
            continue;
        }
        model = next;
        at = std::move(tried);
        damping *= 0.1;
        if (before - after < 1e-9 * before) break;
    }
    return at;
}

/// What one edge says is off in its own way all along: edges are counted, not points; each by what would change without it.
Matrix covariance_of(const Edges& at, const Prior& prior) {
    const Matrix inverse = (at.information + prior.information()).inverse();
    Matrix by_edges = prior.by_edge();
    for (const auto& [information, gradient] : at.own) {
        const Vector without = (Matrix::Identity() - information * inverse).partialPivLu().solve(gradient);
        by_edges += without * without.transpose();
    }
    return inverse * by_edges * inverse;
}

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

std::vector<LongEdge> long_edges(LumaView picture, std::size_t number, const PlumbLineSettings& settings) {
    EdgePointFinder finder({.working_width = std::max(picture.width, 1), .threshold = 5, .least_gradient = 2, .most_points = 60000});
    std::vector<EdgePoint> points;
    finder.find(picture, points);
    std::vector<std::size_t> order(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return points[a].strength > points[b].strength; });
    const PointMap map(points);
    std::vector<char> taken(points.size(), 0);
    std::vector<LongEdge> edges;
    for (const std::size_t start : order) {
        if (taken[start]) continue;
        taken[start] = 1;
        const auto one_way = follow(points, map, start, 1, taken), other_way = follow(points, map, start, -1, taken);
        LongEdge edge;
        edge.picture = number;
        for (auto i = other_way.rbegin(); i != other_way.rend(); ++i) edge.points.push_back(place_of(points[*i]));
        edge.points.push_back(place_of(points[start]));
        for (const std::size_t i : one_way) edge.points.push_back(place_of(points[i]));
        if (edge.points.size() < 12 || length_of(edge) < settings.least_length * picture.width || turn_of(edge) > settings.largest_turn) continue;
        edges.push_back(std::move(edge));
    }
    return edges;
}

Result<PlumbLine> straighten(std::vector<LongEdge> edges, const CameraModel& start, const PlumbLineSettings& settings) {
    const auto too_few = [&](std::size_t count) {
        return Error{
            fmt::format("{} long edges that can be straight, {} or more are needed: take pictures with door frames, skirtings and ceiling edges all over",
                        count, settings.least_lines)};
    };
    if (start.kind != Distortion::plumb_bob) {
        return Error{fmt::format("the camera's lens is of the kind {}: straight lines are made straight for plumb_bob only; use a board", name_of(start.kind))};
    }
    drop_repeated(edges);
    if (edges.size() < settings.least_lines) return too_few(edges.size());
    PlumbLine result;
    result.model = first_lens(make_camera_model(start.width, start.height, start.fx, start.fy, start.cx, start.cy), edges);
    choose(result.model, edges, 2 * settings.outlier);
    const Prior prior(start, settings);
    Edges at;
    for (int selection = 0; selection < 12; ++selection) {
        if (count_used(edges) < settings.least_lines) return too_few(count_used(edges));
        at = minimise(result.model, edges, prior);
        if (!choose(result.model, edges, settings.outlier)) break;
    }
    at = linearise(result.model, edges);
    const Matrix covariance = covariance_of(at, prior);
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
    result.edges = std::move(edges);
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
