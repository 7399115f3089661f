#include "roomfix/smooth/stretch.hpp"

#include <ceres/crs_matrix.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>

#include "roomfix/smooth/residual_series.hpp"
#include "roomfix/smooth/slices.hpp"
#include "roomfix/smooth/slow_values.hpp"
#include "roomfix/smooth/terms.hpp"

namespace roomfix {
namespace {

constexpr double motion_gate = 60;       // squared distance at which a robot rather was carried than drove
constexpr double carried_weight = 1e-6;  // of what its wheels or momentum say then

/// Of each source: by which factor its variances are too small.
using SourceNoise = std::map<int, double>;

/// m/s, over the whole trajectory.
double mean_speed(const Trajectory& trajectory) { return way_along(trajectory).back() / std::max(to_seconds(trajectory.end() - trajectory.start()), 1e-3); }

/// An observation with its term.
struct Observed {
    const Measured* measured;
    MeasuredTerm term;
};

/// Those that show something where the trajectory runs.
std::vector<Observed> observed_along(const Trajectory& trajectory, const std::vector<Measured>& measured, int robot, const TrackingModels& models) {
    std::vector<Observed> all;
    for (const Measured& m : measured) {
        MeasuredTerm term = measured_term(m, robot, trajectory, models);
        if (term.cost) all.push_back({&m, std::move(term)});
    }
    return all;
}

/// Of the errors that change fast, the fastest.
ChangeRate fastest_of(const std::vector<Observed>& observed, double speed) {
    ChangeRate fastest;
    for (const Observed& o : observed) {
        for (const SlowState& state : o.term.slow) {
            if (!changes_fast(state, speed)) continue;
            fastest.per_second = std::max(fastest.per_second, state.per_second);
            fastest.per_metre = std::max(fastest.per_metre, state.per_metre);
        }
    }
    return fastest;
}

/// One least-squares problem over one stretch of one robot's way. The knots are changed in place.
class StretchProblem {
public:
    /// `observed`: along this trajectory. `speed`: m/s, on average.
    StretchProblem(const SmoothingTask& task, Trajectory& trajectory, std::vector<Observed> observed, double speed, double widening, const SourceNoise& noise,
                   const StretchProblem* earlier)
        : task_(task),
          trajectory_(trajectory),
          slow_(problem_, Slices(trajectory, fastest_of(observed, speed)), task.settings.lasting, speed, earlier ? &earlier->slow_ : nullptr),
          widening_(widening) {
        for (Knot& knot : trajectory_.knots) problem_.AddParameterBlock(knot.data(), 6);
        problem_.AddResidualBlock(loose_term(trajectory_.knots.front()).release(), nullptr, trajectory_.knots.front().data());
        for (std::size_t k = 0; k + 1 < trajectory_.knots.size(); ++k) add_motion(k);
        const std::vector<double> looks = looks_alike(observed);
        for (std::size_t i = 0; i < observed.size(); ++i) add_observed(observed[i], looks[i], noise);
    }

    /// The trajectory stays as it is, only slow errors are sought.
    void keep_knots() {
        for (Knot& knot : trajectory_.knots) problem_.SetParameterBlockConstant(knot.data());
    }

    /// What is left over of all terms.
    double solve() {
        ceres::Solver::Options options;
        options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
        options.max_num_iterations = task_.settings.most_iterations;
        options.function_tolerance = 1e-8;
        options.logging_type = ceres::SILENT;
        options.num_threads = 1;  // so that sums are added in one order
        ceres::Solver::Summary summary;
        ceres::Solve(options, &problem_, &summary);
        return summary.IsSolutionUsable() ? summary.final_cost : std::numeric_limits<double>::infinity();
    }

    /// How much larger than stated, or longer lasting, what is left over of each source is.
    SourceNoise left_over() {
        std::map<std::tuple<int, int, int>, ResidualSeries> series;  // of each source, thing that it sees, and number of residuals
        std::vector<double> residual;
        for (const Block& block : blocks_) {
            residual.resize(static_cast<std::size_t>(block.dimensions));
            double cost = 0;
            if (!problem_.EvaluateResidualBlock(block.id, false, &cost, residual.data(), nullptr)) continue;
            if (is_doubted(block, 2 * cost)) continue;
            series[{block.source, block.thing, block.dimensions}].add(block.time, residual);
        }
        std::map<int, std::vector<const ResidualSeries*>> of_source;
        for (const auto& [key, one] : series) of_source[std::get<0>(key)].push_back(&one);
        SourceNoise noise;
        for (const auto& [source, all] : of_source) noise[source] = variance_factor(all);
        return noise;
    }

    SmoothedCovariance covariance() {
        const Slices& slices = slow_.slices();
        std::vector<std::vector<double*>> of_slice(slices.size());
        std::vector<double*> common;
        for (const SlowValues::Value& slow : slow_.all()) (slow.slice ? of_slice[*slow.slice] : common).push_back(slow.value);
        ceres::Problem::EvaluateOptions options;
        UnknownColumns columns;
        Eigen::Index column = 0;
        for (std::size_t s = 0; s < slices.size(); ++s) {
            const Eigen::Index start = column;
            const std::size_t end = s + 1 < slices.size() ? slices.first_knot(s + 1) : trajectory_.knots.size();
            for (std::size_t k = slices.first_knot(s); k < end; ++k) {
                options.parameter_blocks.push_back(trajectory_.knots[k].data());
                columns.knots.push_back(column);
                column += 6;
            }
            options.parameter_blocks.insert(options.parameter_blocks.end(), of_slice[s].begin(), of_slice[s].end());
            column += static_cast<Eigen::Index>(of_slice[s].size());
            columns.slices.push_back(column - start);
        }
        options.parameter_blocks.insert(options.parameter_blocks.end(), common.begin(), common.end());
        ceres::CRSMatrix crs;
        if (!problem_.Evaluate(options, nullptr, nullptr, nullptr, &crs)) return {};
        const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> jacobian(crs.num_rows, crs.num_cols, static_cast<Eigen::Index>(crs.values.size()),
                                                                                      crs.rows.data(), crs.cols.data(), crs.values.data());
        return smoothed_covariance(jacobian, columns);
    }

    /// What all slices have in common, in the order of the covariance.
    std::vector<SlowEstimate> slow() const {
        std::vector<SlowEstimate> estimates;
        for (const SlowValues::Value& slow : slow_.all()) {
            if (!slow.slice) estimates.push_back({slow.state, *slow.value});
        }
        return estimates;
    }

    /// Of the robot's own detector.
    void add_known_errors(Belief& belief, Nanoseconds time) const { slow_.add_known(belief, of_detector, time); }

    std::map<int, SightingCount> counts() {
        std::map<int, SightingCount> counts;
        for (const Block& block : blocks_) {
            SightingCount& count = counts[block.source];
            ++count.all;
            double cost = 0;
            count.doubted += problem_.EvaluateResidualBlock(block.id, false, &cost, nullptr, nullptr) && is_doubted(block, 2 * cost);
        }
        return counts;
    }

private:
    struct Block {
        ceres::ResidualBlockId id;
        int source, thing;
        Nanoseconds time;
        int dimensions;
    };

    bool is_doubted(const Block& block, double squared) const { return squared > task_.models.settings.gate + 2 * block.dimensions; }

    void add_motion(std::size_t k) {
        const auto robot = static_cast<std::size_t>(task_.robot);
        const Nanoseconds time = trajectory_.times[k];
        double* a = trajectory_.knots[k].data();
        double* b = trajectory_.knots[k + 1].data();
        auto* loss = new OutlierLoss(widening_ * motion_gate, carried_weight);
        const OdometryNoise& noise = task_.models.wheels[robot];
        const Nanoseconds delay = from_seconds(noise.delay);
        const auto step = task_.history.driven[robot].step(time - delay, trajectory_.times[k + 1] - delay);
        if (!step) {
            problem_.AddResidualBlock(momentum_term(trajectory_.seconds_after(k), task_.models.motion[robot]).release(), loss, a, b);
            return;
        }
        const OdometryPrior& prior = task_.models.odometry[robot];
        double* scale = slow_.walking(state_scale, prior.scale_sigma, noise.scale_walk, time);
        double* turn_scale = slow_.walking(state_turn_scale, prior.turn_scale_sigma, noise.scale_walk, time);
        double* drift = slow_.walking(state_drift, prior.drift_sigma, noise.drift_walk, time);
        problem_.AddResidualBlock(wheel_term(*step, noise).release(), loss, a, b, scale, turn_scale, drift);
    }

    /// Of each observation: how many there are of the same thing with the robot about where it was then.
    std::vector<double> looks_alike(const std::vector<Observed>& observed) const {
        const SmootherSettings& settings = task_.settings;
        std::vector<double> looks(observed.size(), 1);
        if (!(settings.same_place > 0)) return looks;
        using Cell = std::tuple<int, int, long, long, long>;
        std::map<Cell, double> counts;
        const auto cell_of = [&](const Measured& m) {
            const Knot at = trajectory_.at(m.time);
            const auto number = [](double value, double size) { return std::lround(value / size); };
            return Cell{m.source, thing_of(m), number(at[0], settings.same_place), number(at[1], settings.same_place),
                        number(wrap_angle(at[2]), settings.same_heading)};
        };
        for (const Observed& o : observed) ++counts[cell_of(*o.measured)];
        for (std::size_t i = 0; i < observed.size(); ++i) looks[i] = counts[cell_of(*observed[i].measured)];
        return looks;
    }

    void add_observed(Observed& observed, double looks, const SourceNoise& noise) {
        const Measured& m = *observed.measured;
        MeasuredTerm& term = observed.term;
        const std::size_t k = trajectory_.knot_before(m.time);
        std::vector<double*> parameters = {trajectory_.knots[k].data(), trajectory_.knots[k + 1].data()};
        for (const SlowState& state : term.slow) parameters.push_back(slow_.of(state, m.time));
        auto* loss = term.has_tails ? nullptr : new OutlierLoss(widening_ * (task_.models.settings.gate + 2 * term.dimensions));
        const auto factor = noise.find(m.source);
        auto* weighed = new ceres::ScaledLoss(loss, 1 / (looks * (factor == noise.end() ? 1 : factor->second)), ceres::TAKE_OWNERSHIP);
        const auto id = problem_.AddResidualBlock(term.cost.release(), weighed, parameters);
        blocks_.push_back({id, m.source, thing_of(m), m.time, term.dimensions});
    }

    const SmoothingTask& task_;
    Trajectory& trajectory_;
    ceres::Problem problem_;
    SlowValues slow_;
    std::vector<Block> blocks_;
    double widening_;
};

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

}  // namespace

Trajectories first_trajectories(const Tracker& tracker, const std::vector<Fix>& tracked, const SmootherSettings& settings) {
    const TrackingModels& models = tracker.models();
    const std::size_t robots = models.site.robots.size();
    std::vector<std::vector<Fix>> fixes_of(robots);
    for (const Fix& fix : tracked) {
        const auto robot = models.site.robot(fix.robot);
        if (robot && !models.site.robots[static_cast<std::size_t>(*robot)].many) fixes_of[static_cast<std::size_t>(*robot)].push_back(fix);
    }
    Trajectories trajectories(robots);
    for (std::size_t r = 0; r < robots; ++r) {
        if (fixes_of[r].empty()) continue;
        const std::size_t group = tracker.group_of(static_cast<int>(r));
        const auto times = knot_times(moments(static_cast<int>(r), group, fixes_of[r], *tracker.history()), settings.step, settings.closest);
        trajectories[r] = first_trajectory(fixes_of[r], times, tracker.history()->driven[r], like_turns_of(group, *tracker.history()));
    }
    return trajectories;
}

SmoothedStretch smooth_stretch(const SmoothingTask& task, const Trajectory& start, const Trajectories& others, const std::function<void(double)>& progress) {
    constexpr double solves = 4;
    SmoothedStretch stretch{start, {}, {}, {}, true};
    Trajectories trajectories = others;
    SourceNoise noise;
    const double speed = mean_speed(start);
    // `taken`: where the robot is taken to be; solving changes it in place.
    const auto problem_along = [&](Trajectory& taken, double widening, const StretchProblem* earlier) {
        trajectories[static_cast<std::size_t>(task.robot)] = taken;
        KnownErrors known;
        if (earlier != nullptr) known = [&](Belief& belief, Nanoseconds time) { earlier->add_known_errors(belief, time); };
        const auto measured = measured_of(task.robot, task.history, task.groups, task.models, trajectories, known);
        return std::make_unique<StretchProblem>(task, taken, observed_along(taken, measured, task.robot, task.models), speed, widening, noise, earlier);
    };
    std::unique_ptr<StretchProblem> problem;
    int solved = 0;
    const auto solve = [&](double widening) {
        problem = problem_along(stretch.trajectory, widening, problem.get());
        const double cost = problem->solve();
        if (progress) progress(++solved / solves);
        return cost;
    };
    for (const double widening : {100.0, 10.0, 1.0}) solve(widening);
    noise = problem->left_over();
    const double cost = solve(1);
    Trajectory kept = start;
    const auto of_start = problem_along(kept, 1, problem.get());
    of_start->keep_knots();
    stretch.settled = cost <= of_start->solve();
    stretch.covariance = problem->covariance();
    stretch.slow = problem->slow();
    stretch.counts = problem->counts();
    return stretch;
}

}  // namespace roomfix
