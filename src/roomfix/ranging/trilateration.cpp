#include "roomfix/ranging/trilateration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/levenberg_marquardt.hpp"
#include "roomfix/geometry/multilateration.hpp"

namespace roomfix {
namespace {

struct Problem {
    std::span<const BeaconRange> ranges;
    std::span<const BeaconDifference> differences;
    double height;
    const TrilaterationSettings& settings;
    double blur = 1;  // sigmas are taken that many times larger
};

/// x, y, shared delay: m
using State = Eigen::Vector3d;

/// Everything that one state makes of the measurements.
struct Linearised {
    double log_likelihood = 0;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// |p - beacon| and its derivative by x, y.
double distance_to(const Eigen::Vector3d& beacon, const State& state, double height, Eigen::Vector2d& slope) {
    const Eigen::Vector3d way(state.x() - beacon.x(), state.y() - beacon.y(), height - beacon.z());
    const double distance = std::max(way.norm(), 1e-9);
    slope = way.head<2>() / distance;
    return distance;
}

RangeLikelihood plain_likelihood(double error, double sigma) {
    const double weight = 1 / (sigma * sigma);
    return {-0.5 * weight * error * error - std::log(sigma), -weight * error, weight, 1};
}

/// Calls `visit` with each measurement's derivative by the state and its likelihood.
template <class Visit>
void visit_measurements(const Problem& problem, const State& state, Visit&& visit) {
    Eigen::Vector2d slope, far;
    const TrilaterationSettings& s = problem.settings;
    for (const BeaconRange& r : problem.ranges) {
        const double error = r.range - distance_to(r.beacon, state, problem.height, slope) - state.z();
        const double sigma = problem.blur * r.sigma;
        visit(Eigen::Vector3d(slope.x(), slope.y(), 1), s.robust ? range_likelihood(error, sigma, s.late) : plain_likelihood(error, sigma));
    }
    for (const BeaconDifference& d : problem.differences) {
        const double predicted = distance_to(d.b, state, problem.height, far) - distance_to(d.a, state, problem.height, slope);
        const double error = d.difference - predicted;
        const double sigma = problem.blur * d.sigma;
        visit(Eigen::Vector3d(far.x() - slope.x(), far.y() - slope.y(), 0),
              s.robust ? difference_likelihood(error, sigma, s.late) : plain_likelihood(error, sigma));
    }
}

Linearised linearise(const Problem& problem, const State& state) {
    Linearised l;
    visit_measurements(problem, state, [&](const Eigen::Vector3d& slope, const RangeLikelihood& likelihood) {
        l.log_likelihood += likelihood.log_density;
        l.information += likelihood.curvature * slope * slope.transpose();
        l.gradient -= likelihood.slope * slope;
    });
    const double mean = problem.settings.shared_delay;
    if (mean > 0) {  // exponential
        l.log_likelihood -= state.z() / mean;
        l.gradient.z() -= 1 / mean;
        l.information(2, 2) += 1 / (mean * mean);
    } else {
        l.information.row(2) = l.information.col(2).transpose() = Eigen::Vector3d(0, 0, 1);
        l.gradient.z() = 0;
    }
    return l;
}

/// Damped Gauss-Newton; each step must make the measurements more likely.
State refine(const Problem& problem, State state, Linearised& at) {
    at = linearise(problem, state);
    levenberg_marquardt({.start = 1e-4, .rounds = 60}, [&](double damping) {
        // Circles that touch leave a direction open: the damping is the same in all of them.
        const Eigen::Matrix3d normal = at.information + damping * (at.information.trace() + 1e-9) * Eigen::Matrix3d::Identity();
        const State step = normal.ldlt().solve(at.gradient);
        if (!step.allFinite()) return StepResult::impossible;
        State moved = state + step;
        moved.z() = std::max(moved.z(), 0.0);
        const Linearised next = linearise(problem, moved);
        if (!(next.log_likelihood >= at.log_likelihood)) return StepResult::worse;
        state = moved;
        at = next;
        return step.norm() < 1e-9 ? StepResult::settled : StepResult::better;
    });
    return state;
}

std::vector<Eigen::Vector2d> starts_of(const Problem& problem) {
    std::vector<Circle> circles;
    for (const BeaconRange& r : problem.ranges) {
        const double rise = r.beacon.z() - problem.height;
        circles.push_back({r.beacon.head<2>(), std::sqrt(std::max(r.range * r.range - rise * rise, 0.0))});
    }
    std::vector<Eigen::Vector2d> starts;
    const auto add = [&](std::span<const Circle> some) {
        for (const auto& p : meeting_points(some)) starts.push_back(p);
    };
    add(circles);
    if (!problem.settings.robust && !starts.empty()) return starts;
    const std::size_t most = std::min<std::size_t>(circles.size(), 8);
    for (std::size_t i = 0; i < most; ++i) {
        for (std::size_t j = i + 1; j < most; ++j) {
            add(std::array{circles[i], circles[j]});
            for (std::size_t k = j + 1; k < most; ++k) add(std::array{circles[i], circles[j], circles[k]});
        }
    }
    if (problem.differences.empty()) return starts;
    // Hyperbolas: a grid over twice the beacons' extent.
    Eigen::AlignedBox2d box;
    for (const BeaconDifference& d : problem.differences) box.extend(d.a.head<2>()).extend(d.b.head<2>());
    for (const Circle& c : circles) box.extend(c.centre);
    const Eigen::Vector2d reach = 0.5 * box.sizes() + Eigen::Vector2d::Constant(0.25 * box.sizes().maxCoeff() + 0.5);
    constexpr int steps = 12;
    for (int i = 0; i <= steps; ++i) {
        for (int j = 0; j <= steps; ++j) {
            starts.push_back(box.center() +
                             2 * reach.cwiseProduct(Eigen::Vector2d(static_cast<double>(i) / steps - 0.5, static_cast<double>(j) / steps - 0.5)));
        }
    }
    return starts;
}

}  // namespace

Result<Trilateration> trilaterate(std::span<const BeaconRange> ranges, std::span<const BeaconDifference> differences, double height,
                                  const TrilaterationSettings& settings) {
    const Problem problem{ranges, differences, height, settings};
    if (ranges.size() + differences.size() < 2) return Error{"a place needs two ranges at least: add beacons or wait for more ranges"};
    struct Candidate {
        State state;
        Linearised at;
    };
    std::vector<Candidate> candidates;
    Problem blurred = problem;
    blurred.blur = 10;
    for (const Eigen::Vector2d& start : starts_of(problem)) {
        if (!start.allFinite()) continue;
        // From the start itself, and by way of larger sigmas, which see measurements that are far off here.
        const State first(start.x(), start.y(), 0);
        Candidate direct;
        direct.state = refine(problem, first, direct.at);
        Candidate gradual;
        gradual.state = refine(problem, refine(blurred, first, gradual.at), gradual.at);
        candidates.push_back(direct);
        candidates.push_back(gradual);
    }
    std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.at.log_likelihood > b.at.log_likelihood; });

    Trilateration result;
    std::vector<State> states;
    double best = 0;
    double sum = 0;
    for (const Candidate& c : candidates) {
        if (result.places.size() == result.places.capacity()) break;
        if (!result.places.empty() && c.at.log_likelihood < best - 8) break;
        const Eigen::FullPivLU<Eigen::Matrix3d> factor(c.at.information);
        if (!factor.isInvertible()) continue;
        const Eigen::Matrix2d covariance = factor.inverse().topLeftCorner<2, 2>();
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance, Eigen::EigenvaluesOnly);
        if (!(axes.eigenvalues()[0] > 0 && axes.eigenvalues()[1] < settings.largest_sigma * settings.largest_sigma)) continue;
        const Eigen::Vector2d position = c.state.head<2>();
        const auto same = [&](const TrilaterationPlace& other) {
            const Eigen::Vector2d off = other.position - position;
            return off.norm() < 1e-3 || off.dot(Eigen::Matrix2d(covariance + other.covariance).inverse() * off) < 4;
        };
        if (std::any_of(result.places.begin(), result.places.end(), same)) continue;
        if (result.places.empty()) best = c.at.log_likelihood;
        result.places.push_back({position, covariance, std::exp(c.at.log_likelihood - best)});
        sum += result.places[result.places.size() - 1].weight;
        states.push_back(c.state);
    }
    if (result.places.empty()) return Error{"the beacons leave a direction open: they stand in a line with the receiver, or too few ranges came straight"};
    for (auto& place : result.places) place.weight /= sum;
    result.shared_delay = states[0].z();
    visit_measurements(problem, states[0], [&](const Eigen::Vector3d&, const RangeLikelihood& l) { result.on_time.push_back(l.on_time); });
    return result;
}

}  // namespace roomfix
