#include "roomfix/smooth/smoother.hpp"

#include <ceres/crs_matrix.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>

#include "roomfix/smooth/knot_covariance.hpp"
#include "roomfix/smooth/residual_series.hpp"
#include "roomfix/smooth/slow_values.hpp"
#include "roomfix/smooth/terms.hpp"

namespace roomfix {
namespace {

constexpr double motion_gate = 60;       // squared distance at which a robot rather was carried than drove
constexpr double carried_weight = 1e-6;  // of what its wheels or momentum say then

using Trajectories = std::vector<std::optional<Trajectory>>;

/// Of each source: by which factor its variances are too small.
using SourceNoise = std::map<int, double>;

/// A smoothed stretch: its trajectory and what is uncertain of it.
struct Stretch {
    Trajectory trajectory;
    std::vector<PairCovariance> pairs;
};

struct Task {
    int robot;
    const TrackerHistory& history;
    const std::vector<Group>& groups;
    const TrackingModels& models;
    const SmootherSettings& settings;
};

/// One least-squares problem over one stretch of one robot's way. The knots are changed in place.
class StretchProblem {
public:
    StretchProblem(const Task& task, Trajectory& trajectory, const std::vector<Measured>& measured, double widening, const SourceNoise& noise,
                   const StretchProblem* earlier)
        : task_(task), trajectory_(trajectory), slow_(problem_, trajectory.start(), earlier ? &earlier->slow_ : nullptr), widening_(widening) {
        for (Knot& knot : trajectory_.knots) problem_.AddParameterBlock(knot.data(), 6);
        problem_.AddResidualBlock(loose_term(trajectory_.knots.front()).release(), nullptr, trajectory_.knots.front().data());
        for (std::size_t k = 0; k + 1 < trajectory_.knots.size(); ++k) add_motion(k);
        for (const Measured& m : measured) add_measured(m, noise);
    }

    void solve() {
        ceres::Solver::Options options;
        options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
        options.max_num_iterations = task_.settings.most_iterations;
        options.function_tolerance = 1e-8;
        options.logging_type = ceres::SILENT;
        options.num_threads = 1;  // so that sums are added in one order
        ceres::Solver::Summary summary;
        ceres::Solve(options, &problem_, &summary);
    }

    /// How much larger than stated, or longer lasting, what is left over of each source is.
    SourceNoise left_over() {
        std::map<std::tuple<int, int, int>, ResidualSeries> series;  // of each source, thing that it sees, and number of residuals
        std::vector<double> residual;
        for (const Block& block : blocks_) {
            residual.resize(static_cast<std::size_t>(block.dimensions));
            double cost = 0;
            if (!problem_.EvaluateResidualBlock(block.id, false, &cost, residual.data(), nullptr)) continue;
            const double squared = 2 * cost;
            if (squared > task_.models.settings.gate + 2 * block.dimensions) continue;
            series[{block.source, block.thing, block.dimensions}].add(block.time, residual);
        }
        std::map<int, std::vector<const ResidualSeries*>> of_source;
        for (const auto& [key, one] : series) of_source[std::get<0>(key)].push_back(&one);
        SourceNoise noise;
        for (const auto& [source, all] : of_source) noise[source] = variance_factor(all);
        return noise;
    }

    std::vector<PairCovariance> covariances() {
        ceres::Problem::EvaluateOptions options;
        for (Knot& knot : trajectory_.knots) options.parameter_blocks.push_back(knot.data());
        options.parameter_blocks.insert(options.parameter_blocks.end(), slow_.all().begin(), slow_.all().end());
        ceres::CRSMatrix crs;
        if (!problem_.Evaluate(options, nullptr, nullptr, nullptr, &crs)) return {};
        const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> jacobian(crs.num_rows, crs.num_cols, static_cast<Eigen::Index>(crs.values.size()),
                                                                                      crs.rows.data(), crs.cols.data(), crs.values.data());
        return knot_covariances(jacobian, trajectory_.knots.size());
    }

private:
    void add_motion(std::size_t k) {
        const auto robot = static_cast<std::size_t>(task_.robot);
        const Nanoseconds time = trajectory_.times[k];
        double* a = trajectory_.knots[k].data();
        double* b = trajectory_.knots[k + 1].data();
        auto* doubt = new DoubtLoss(widening_ * motion_gate, carried_weight);
        const auto step = task_.history.driven[robot].step(time, trajectory_.times[k + 1]);
        if (!step) {
            problem_.AddResidualBlock(momentum_term(trajectory_.seconds_after(k), task_.models.motion[robot]).release(), doubt, a, b);
            return;
        }
        const OdometryNoise& noise = task_.models.settings.odometry;
        const OdometryPrior& prior = task_.models.odometry[robot];
        double* scale = slow_.walking(state_scale, prior.scale_sigma, noise.scale_walk, time);
        double* drift = slow_.walking(state_drift, prior.drift_sigma, noise.drift_walk, time);
        problem_.AddResidualBlock(wheel_term(*step, noise).release(), doubt, a, b, scale, drift);
    }

    void add_measured(const Measured& m, const SourceNoise& noise) {
        MeasuredTerm term = measured_term(m, task_.robot, trajectory_, task_.models);
        if (!term.cost) return;
        const std::size_t k = trajectory_.knot_before(m.time);
        std::vector<double*> parameters = {trajectory_.knots[k].data(), trajectory_.knots[k + 1].data()};
        for (const SlowState& state : term.slow) parameters.push_back(slow_.of(state, m.time));
        auto* doubt = term.has_tails ? nullptr : new DoubtLoss(widening_ * (task_.models.settings.gate + 2 * term.dimensions));
        const auto factor = noise.find(m.source);
        auto* weighed = new ceres::ScaledLoss(doubt, factor == noise.end() ? 1 : 1 / factor->second, ceres::TAKE_OWNERSHIP);
        const auto id = problem_.AddResidualBlock(term.cost.release(), weighed, parameters);
        blocks_.push_back({id, m.source, thing_of(m), m.time, term.dimensions});
    }

    struct Block {
        ceres::ResidualBlockId id;
        int source, thing;
        Nanoseconds time;
        int dimensions;
    };

    const Task& task_;
    Trajectory& trajectory_;
    ceres::Problem problem_;
    SlowValues slow_;
    std::vector<Block> blocks_;
    double widening_;
};

/// First with hardly any observation thrown out, so that a start that is off can move; then with the tracker's own doubts; in the end
/// with each source's noise as it turned out.
Stretch smooth_stretch(const Task& task, const Trajectory& start, const Trajectories& others) {
    Stretch stretch{start, {}};
    Trajectories trajectories = others;
    std::unique_ptr<StretchProblem> problem;
    SourceNoise noise;
    const auto solve = [&](double widening) {
        trajectories[static_cast<std::size_t>(task.robot)] = stretch.trajectory;
        const auto measured = measured_of(task.robot, task.history, task.groups, task.models, trajectories);
        problem = std::make_unique<StretchProblem>(task, stretch.trajectory, measured, widening, noise, problem.get());
        problem->solve();
    };
    for (const double widening : {100.0, 10.0, 1.0}) solve(widening);
    noise = problem->left_over();
    solve(1);
    stretch.pairs = problem->covariances();
    return stretch;
}

/// So many turns in a circle look the same wherever a robot of the group was seen.
int like_turns_of(std::size_t group, const TrackerHistory& history) {
    int turns = 1;
    const auto take = [&](const PoseObservation& o) { turns = std::max(turns, o.like_turns); };
    for (const auto& told : history.events) {
        if (told.group != group) continue;
        if (const auto* pose = std::get_if<PoseObservation>(&told.event.what)) take(*pose);
        if (const auto* frame = std::get_if<GroupSighting>(&told.event.what)) std::for_each(frame->robots.begin(), frame->robots.end(), take);
    }
    return turns;
}

/// When something was measured of the robot, while the tracker was there to see it.
std::vector<Nanoseconds> moments(int robot, std::size_t group, const std::vector<Fix>& fixes, const TrackerHistory& history) {
    const Nanoseconds from = fixes.front().time, to = fixes.back().time;
    std::vector<Nanoseconds> times = {from, to};
    for (const auto& told : history.events) {
        const int about = robot_of(told.event);
        if (told.group == group && (about < 0 || about == robot) && told.event.time > from && told.event.time < to) times.push_back(told.event.time);
    }
    return times;
}

/// The fix as the smoothed trajectory has it.
void correct(Fix& fix, const Stretch& stretch, const Task& task) {
    const Trajectory& way = stretch.trajectory;
    const std::size_t k = way.knot_before(fix.time);
    const double part = way.part_in(k, fix.time);
    const KnotWeights weights = way.weights_in(k, fix.time);
    Eigen::Matrix<double, 3, 12> by_pair;
    for (int i = 0; i < 4; ++i) by_pair.middleCols<3>(3 * i) = weights(0, i) * Eigen::Matrix3d::Identity();
    Eigen::Matrix3d covariance = by_pair * stretch.pairs[k] * by_pair.transpose();
    // Between the knots the robot may swing a little: white noise pinned at both ends.
    const auto robot = static_cast<std::size_t>(task.robot);
    const MotionModel& motion = task.models.motion[robot];
    const double swing = std::pow(part * (1 - part) * way.seconds_after(k), 3) / 3;
    covariance.diagonal() += swing * Eigen::Vector3d(motion.acceleration, motion.acceleration, motion.turning).cwiseAbs2();
    const bool known = worst_sigma(covariance.topLeftCorner<2, 2>()) < task.models.settings.lost;
    if (fix.status == FixStatus::none && !known) return;
    const Knot at = between(way.knots[k], way.knots[k + 1], weights);
    fix.pose = {at[0], at[1], wrap_angle(at[2])};
    fix.covariance = 0.5 * (covariance + covariance.transpose());
    fix.nis.clear();
    fix.hypotheses.clear();
    if (fix.status == FixStatus::none) fix.status = FixStatus::coasting;
    fix.yaw_known = covariance(2, 2) < 0.25;
    fix.reason.clear();
}

}  // namespace

std::vector<Fix> smooth(const Tracker& tracker, const std::vector<Fix>& tracked, const SmootherSettings& settings,
                        const std::function<void(double)>& progress) {
    std::vector<Fix> smoothed = tracked;
    if (tracker.history() == nullptr || tracked.empty()) return smoothed;
    const TrackingModels& models = tracker.models();
    const std::size_t robots = models.site.robots.size();
    std::vector<std::vector<Fix>> fixes_of(robots);
    std::vector<std::vector<std::size_t>> places_of(robots);  // in `smoothed`
    for (std::size_t i = 0; i < tracked.size(); ++i) {
        const auto robot = models.site.robot(tracked[i].robot);
        if (!robot || models.site.robots[static_cast<std::size_t>(*robot)].many) continue;
        fixes_of[static_cast<std::size_t>(*robot)].push_back(tracked[i]);
        places_of[static_cast<std::size_t>(*robot)].push_back(i);
    }
    Trajectories trajectories(robots);
    for (std::size_t r = 0; r < robots; ++r) {
        if (fixes_of[r].empty()) continue;
        const std::size_t group = tracker.group_of(static_cast<int>(r));
        const auto times = knot_times(moments(static_cast<int>(r), group, fixes_of[r], *tracker.history()), settings.step, settings.closest);
        trajectories[r] = first_trajectory(fixes_of[r], times, tracker.history()->driven[r], like_turns_of(group, *tracker.history()));
    }
    for (std::size_t r = 0; r < robots; ++r) {
        if (!trajectories[r]) continue;
        const Task task{static_cast<int>(r), *tracker.history(), tracker.groups(), models, settings};
        const Trajectory& whole = *trajectories[r];
        const Nanoseconds window = settings.window > 0 ? from_seconds(settings.window) : whole.end() - whole.start();
        const Nanoseconds overlap = from_seconds(settings.overlap);
        std::size_t next = 0;
        for (Nanoseconds from = whole.start(); from < whole.end(); from += window) {
            const Nanoseconds to = from + window;
            const Stretch stretch = smooth_stretch(task, whole.part(from - overlap, to + overlap), trajectories);
            for (; next < places_of[r].size() && (smoothed[places_of[r][next]].time < to || to >= whole.end()); ++next) {
                Fix& fix = smoothed[places_of[r][next]];
                if (!stretch.pairs.empty() && stretch.trajectory.covers(fix.time)) correct(fix, stretch, task);
            }
            if (progress)
                progress((static_cast<double>(r) + std::min(1.0, to_seconds(to - whole.start()) / to_seconds(whole.end() - whole.start()))) /
                         static_cast<double>(robots));
        }
    }
    return smoothed;
}

}  // namespace roomfix
