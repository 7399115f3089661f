#include "roomfix/smooth/terms.hpp"

#include <ceres/autodiff_cost_function.h>

#include <cmath>
#include <functional>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/estimate/landmark_model.hpp"
#include "roomfix/observation/range_noise.hpp"

namespace roomfix {
namespace {

using RowMajor6 = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

/// A belief that is only a list of states: what the measurement models need to be linearised at.
Belief& scratch_belief() {
    thread_local Belief belief;
    belief.size = core_states;
    belief.slow.clear();
    belief.mean.setZero();
    belief.covariance.topLeftCorner<core_states, core_states>().setZero();
    return belief;
}

std::vector<SlowState> slow_states_of(const Belief& belief) { return {belief.slow.begin(), belief.slow.end()}; }

/// Sets a scratch belief to the trajectory at one time and to the values of the slow states.
const Belief& belief_at_parameters(double const* const* parameters, const KnotWeights& weights, const std::vector<SlowState>& slow) {
    Belief& belief = scratch_belief();
    belief.mean.head<6>() = between(Eigen::Map<const Knot>(parameters[0]), Eigen::Map<const Knot>(parameters[1]), weights);
    for (std::size_t i = 0; i < slow.size(); ++i) {
        belief.slow.push_back(slow[i]);
        belief.mean[belief.size++] = parameters[2 + i][0];
    }
    return belief;
}

/// Derivatives by the belief's states become those by the parameters.
template <class ByState>
void fill_jacobians(const FixedList<int, most_columns>& states, const ByState& by_state, const KnotWeights& weights, std::size_t slow, double** jacobians) {
    const Eigen::Index rows = by_state.rows();
    Eigen::Matrix<double, ByState::RowsAtCompileTime, 6> by_knot = Eigen::Matrix<double, ByState::RowsAtCompileTime, 6>::Zero();
    for (std::size_t i = 0; i < slow; ++i) {
        if (jacobians[2 + i] != nullptr) std::fill_n(jacobians[2 + i], rows, 0.0);
    }
    for (std::size_t k = 0; k < states.size(); ++k) {
        const auto column = by_state.col(static_cast<Eigen::Index>(k));
        if (states[k] < 6) {
            by_knot.col(states[k]) += column;
        } else if (double* out = jacobians[2 + states[k] - core_states]) {
            for (Eigen::Index r = 0; r < rows; ++r) out[r] += column[r];
        }
    }
    for (int end = 0; end < 2; ++end) {
        if (jacobians[end] == nullptr) continue;
        Eigen::Map<RowMajor6> out(jacobians[end], rows, 6);
        for (int rate = 0; rate < 2; ++rate) {
            const int column = 2 * end + rate;
            out.middleCols<3>(3 * rate) = weights(0, column) * by_knot.template leftCols<3>() + weights(1, column) * by_knot.template rightCols<3>();
        }
    }
}

void add_parameter_sizes(std::vector<std::int32_t>& sizes, std::size_t slow) {
    sizes = {6, 6};
    sizes.insert(sizes.end(), slow, 1);
}

/// A measurement model with normal noise.
template <int Rows>
class NormalTerm final : public ceres::CostFunction {
public:
    using Model = std::function<std::optional<Linearised<Rows>>(const Belief&)>;
    NormalTerm(Model model, const KnotWeights& weights, std::vector<SlowState> slow) : model_(std::move(model)), weights_(weights), slow_(std::move(slow)) {
        set_num_residuals(Rows);
        add_parameter_sizes(*mutable_parameter_block_sizes(), slow_.size());
    }
    bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
        const auto measured = model_(belief_at_parameters(parameters, weights_, slow_));
        if (!measured) return false;
        const Eigen::LLT<Eigen::Matrix<double, Rows, Rows>> factor(measured->noise);
        if (factor.info() != Eigen::Success) return false;
        Eigen::Map<Eigen::Matrix<double, Rows, 1>>(residuals, Rows) = factor.matrixL().solve(measured->residual);
        if (jacobians == nullptr) return true;
        const Eigen::Matrix<double, Rows, most_columns> by_state = -factor.matrixL().solve(measured->by_state);
        fill_jacobians(measured->states, by_state, weights_, slow_.size(), jacobians);
        return true;
    }

private:
    Model model_;
    KnotWeights weights_;
    std::vector<SlowState> slow_;
};

template <int Rows>
MeasuredTerm normal_term(typename NormalTerm<Rows>::Model model, const KnotWeights& weights, const Belief& prepared) {
    MeasuredTerm term;
    term.slow = slow_states_of(prepared);
    // Out of sight from where the trajectory is now: it cannot be what was seen.
    if (const auto tried = model(prepared); tried && Eigen::LLT<Eigen::Matrix<double, Rows, Rows>>(tried->noise).info() == Eigen::Success) {
        term.cost = std::make_unique<NormalTerm<Rows>>(std::move(model), weights, term.slow);
    }
    term.dimensions = Rows;
    return term;
}

/// The negative logarithm of a density with one top, as half of a square: r = +-sqrt(2 (log p(top) - log p(e))).
class RangeTerm final : public ceres::CostFunction {
public:
    using Predict = std::function<PredictedValue(const Belief&)>;
    using Likelihood = std::function<RangeLikelihood(double error)>;
    RangeTerm(double measured, double sigma, Predict predict, Likelihood likelihood, const KnotWeights& weights, std::vector<SlowState> slow)
        : measured_(measured), sigma_(sigma), predict_(std::move(predict)), likelihood_(std::move(likelihood)), weights_(weights), slow_(std::move(slow)) {
        set_num_residuals(1);
        add_parameter_sizes(*mutable_parameter_block_sizes(), slow_.size());
        double low = -3 * sigma_, high = 3 * sigma_;
        for (int i = 0; i < 50; ++i) {
            const double middle = 0.5 * (low + high);
            (likelihood_(middle).slope > 0 ? low : high) = middle;
        }
        top_ = 0.5 * (low + high);
        // The slope falls through zero at the top: how fast it does is the curvature there.
        const double near = 1e-3 * sigma_;
        curvature_ = std::max((likelihood_(top_ - near).slope - likelihood_(top_ + near).slope) / (2 * near), 1e-6 / (sigma_ * sigma_));
        highest_ = likelihood_(top_).log_density;
    }
    bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
        const PredictedValue predicted = predict_(belief_at_parameters(parameters, weights_, slow_));
        const double error = measured_ - predicted.value;
        double by_error = std::sqrt(curvature_);
        residuals[0] = (error - top_) * by_error;
        if (std::abs(error - top_) > 0.01 * sigma_) {
            const RangeLikelihood here = likelihood_(error);
            residuals[0] = std::copysign(std::sqrt(2 * std::max(highest_ - here.log_density, 1e-12)), error - top_);
            by_error = -here.slope / residuals[0];
        }
        if (jacobians == nullptr) return true;
        const Eigen::Matrix<double, 1, most_columns> by_state = -by_error * predicted.by_state;
        fill_jacobians(predicted.states, by_state, weights_, slow_.size(), jacobians);
        return true;
    }

private:
    double measured_, sigma_;
    Predict predict_;
    Likelihood likelihood_;
    KnotWeights weights_;
    std::vector<SlowState> slow_;
    double top_ = 0, curvature_ = 0, highest_ = 0;
};

/// Reports the cost of one observation with everything it needs.
struct TermMaker {
    int source, robot;
    const TrackingModels& models;
    KnotWeights weights;
    Knot at;

    Belief& prepared() const {
        Belief& belief = scratch_belief();
        belief.mean.head<6>() = at;
        return belief;
    }
    MeasuredTerm operator()(const PoseObservation& o) const {
        const PoseSource& errors = models.fixed.at(source);
        Belief& belief = prepared();
        add_slow_states(belief, o, errors);
        if (!o.yaw_known) return normal_term<2>([o, &errors](const Belief& b) { return std::optional(linearise_place(b, o, errors)); }, weights, belief);
        return normal_term<3>([o, &errors](const Belief& b) { return std::optional(linearise_pose(b, o, errors)); }, weights, belief);
    }
    MeasuredTerm operator()(const TagSighting& s) const {
        const PoseSource& errors = models.fixed.at(source);
        const View& view = models.views.at(source);
        const SiteRobot& tagged = models.site.robots[static_cast<std::size_t>(s.robot)];
        Belief& belief = prepared();
        add_slow_states(belief, errors, s.time_error);
        return normal_term<8>([s, &view, &tagged, &errors](const Belief& b) { return linearise_tag(b, s.corners, view, tagged, errors, s.time_error); },
                              weights, belief);
    }
    MeasuredTerm operator()(const SeenLandmark& s) const {
        const OnboardSource& camera = models.onboard.at(source);
        const KnownLandmark landmark = models.landmark(s.landmark);
        Belief& belief = prepared();
        add_slow_states(belief, landmark, camera, s.seen.time_error, 3);
        const LandmarkObservation& seen = s.seen;
        if (seen.points.size() == 3) {
            return normal_term<6>([seen, landmark, &camera](const Belief& b) { return linearise_points<3>(b, seen, landmark, camera); }, weights, belief);
        }
        return normal_term<8>([seen, landmark, &camera](const Belief& b) { return linearise_points<4>(b, seen, landmark, camera); }, weights, belief);
    }
    MeasuredTerm operator()(const SeenCorner& s) const {
        const OnboardSource& camera = models.onboard.at(source);
        const SiteCorner& corner = models.site.corners[static_cast<std::size_t>(s.corner)];
        Belief& belief = prepared();
        add_slow_states(belief, s.corner, camera, s.seen.time_error);
        return normal_term<5>([s, &corner, &camera](const Belief& b) { return linearise_corner(b, s.seen, corner, s.corner, camera); }, weights, belief);
    }
    MeasuredTerm operator()(const SeenMark& s) const {
        const DetectorSource& detector = models.detectors[static_cast<std::size_t>(robot)];
        const Mark& mark = models.marks[static_cast<std::size_t>(s.landmark)];
        Belief& belief = prepared();
        add_slow_states(belief, s.seen, s.landmark, detector);
        return normal_term<2>([s, &mark, &detector](const Belief& b) { return std::optional(linearise_sighting(b, s.seen, s.landmark, mark, detector)); },
                              weights, belief);
    }
    MeasuredTerm operator()(const RangeObservation& o) const {
        const RangeSource& receiver = models.receiver(robot, o.receiver);
        const Eigen::Vector3d& beacon = models.site.beacons[static_cast<std::size_t>(o.beacon)].position;
        Belief& belief = prepared();
        add_slow_states(belief, o.beacon, receiver);
        const auto predict = [o, &beacon, &receiver](const Belief& b) { return predict_measured_range(b, b.pose(), o.beacon, beacon, receiver); };
        const double sigma = grown(receiver.factor * o.sigma, receiver.stretch, o.range);
        return range_term(
            o.range, sigma, predict, [sigma, &receiver](double e) { return range_likelihood(e, sigma, receiver.late); }, belief);
    }
    MeasuredTerm operator()(const RangeDifferenceObservation& o) const {
        const RangeSource& receiver = models.receiver(robot, o.receiver);
        const Eigen::Vector3d& first = models.site.beacons[static_cast<std::size_t>(o.beacons[0])].position;
        const Eigen::Vector3d& second = models.site.beacons[static_cast<std::size_t>(o.beacons[1])].position;
        const auto predict = [&first, &second, &receiver](const Belief& b) { return predict_difference(b, b.pose(), first, second, receiver); };
        const double sigma = receiver.factor * o.sigma;
        return range_term(
            o.difference, sigma, predict, [sigma, &receiver](double e) { return difference_likelihood(e, sigma, receiver.late); }, prepared());
    }
    MeasuredTerm range_term(double measured, double sigma, RangeTerm::Predict predict, RangeTerm::Likelihood likelihood, const Belief& belief) const {
        MeasuredTerm term;
        term.slow = slow_states_of(belief);
        term.cost = std::make_unique<RangeTerm>(measured, sigma, std::move(predict), std::move(likelihood), weights, term.slow);
        term.dimensions = 1;
        term.has_tails = true;
        return term;
    }
};

template <class T>
Eigen::Matrix<T, 2, 1> turned_by(const T& angle, const Eigen::Matrix<T, 2, 1>& v) {
    const T c = cos(angle), s = sin(angle);
    return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

struct Momentum {
    double seconds;
    MotionModel model;

    template <class T>
    bool operator()(const T* before, const T* after, T* residual) const {
        const double dt = seconds;
        const double keep = std::exp(-dt / model.memory);
        const bool steers = model.drive == Drive::differential;
        const Eigen::Map<const Eigen::Matrix<T, 6, 1>> a(before), b(after);
        const Eigen::Matrix<T, 2, 1> velocity = a.template segment<2>(3);
        Eigen::Matrix<T, 2, 1> next = velocity * T(keep);
        if (steers) {
            Eigen::Matrix<T, 2, 1> own = turned_by<T>(-a[2], velocity);
            own *= T(keep);
            own.y() *= T(std::exp(-dt / model.slip_memory));
            next = turned_by<T>(a[2] + a[5] * dt, own);
        }
        Eigen::Matrix<T, 2, 1> way = b.template head<2>() - a.template head<2>() - (velocity + next) * T(0.5 * dt);
        Eigen::Matrix<T, 2, 1> pushed = b.template segment<2>(3) - next;
        if (steers) {
            way = turned_by<T>(-a[2], way);
            pushed = turned_by<T>(-a[2], pushed);
        }
        whiten(way.x(), pushed.x(), model.acceleration, residual);
        whiten(way.y(), pushed.y(), steers ? model.side_acceleration : model.acceleration, residual + 2);
        whiten(T(b[2] - a[2] - a[5] * dt), T(b[5] - a[5] * keep), model.turning, residual + 4);
        return true;
    }

    /// By the inverse root of q^2 [[dt^3/3, dt^2/2], [dt^2/2, dt]].
    template <class T>
    void whiten(const T& way, const T& rate, double q, T* out) const {
        const double root = q * std::sqrt(seconds);
        out[0] = rate / root;
        out[1] = (way - rate * (0.5 * seconds)) / (root * seconds / std::sqrt(12.0));
    }
};

struct Wheels {
    OdometryStep step;
    OdometryNoise noise;

    template <class T>
    bool operator()(const T* before, const T* after, const T* scale, const T* turn_scale, const T* drift, T* residual) const {
        const Eigen::Map<const Eigen::Matrix<T, 6, 1>> a(before), b(after);
        const double dt = step.seconds;
        const double length = step.way.norm();
        const double rest = noise.still * noise.still * dt;
        const T stretch = T(1) + scale[0];
        const T missing = turn_scale[0] * step.turned + drift[0] * dt;
        const Eigen::Matrix<T, 2, 1> moved = b.template head<2>() - a.template head<2>();
        const Eigen::Matrix<T, 2, 1> way = turned_by<T>(-(a[2] + missing * 0.5), moved) - step.way.cast<T>() * stretch;
        residual[0] = way.x() / std::sqrt(noise.along * noise.along * length + rest);
        residual[1] = way.y() / std::sqrt(noise.across * noise.across * length + rest);
        residual[2] = (b[2] - a[2] - step.turned - missing) /
                      std::sqrt(noise.turn_per_metre * noise.turn_per_metre * length + noise.turn_per_radian * noise.turn_per_radian * std::abs(step.turned) +
                                noise.still_turn * noise.still_turn * dt);
        const Eigen::Matrix<T, 2, 1> rate = turned_by<T>(-b[2], b.template segment<2>(3)) - step.velocity.cast<T>() * stretch;
        residual[3] = rate.x() / noise.velocity;
        residual[4] = rate.y() / noise.velocity;
        residual[5] = (b[5] - step.turn_rate * (T(1) + turn_scale[0]) - drift[0]) / noise.turn_rate;
        return true;
    }
};

struct Loose {
    Knot about;

    template <class T>
    bool operator()(const T* knot, T* residual) const {
        constexpr double sigma[6] = {100, 100, 3, 5, 5, 5};  // m, m, rad, m/s, m/s, rad/s
        for (int i = 0; i < 6; ++i) residual[i] = (knot[i] - about[i]) / sigma[i];
        return true;
    }
};

}  // namespace

MeasuredTerm measured_term(const Measured& measured, int robot, const Trajectory& trajectory, const TrackingModels& models) {
    const TermMaker make{measured.source, robot, models, trajectory.weights_in(trajectory.knot_before(measured.time), measured.time),
                         trajectory.at(measured.time)};
    return std::visit(make, measured.what);
}

std::unique_ptr<ceres::CostFunction> momentum_term(double seconds, const MotionModel& model) {
    return std::make_unique<ceres::AutoDiffCostFunction<Momentum, 6, 6, 6>>(new Momentum{seconds, model});
}

std::unique_ptr<ceres::CostFunction> wheel_term(const OdometryStep& step, const OdometryNoise& noise) {
    return std::make_unique<ceres::AutoDiffCostFunction<Wheels, 6, 6, 6, 1, 1, 1>>(new Wheels{step, noise});
}

std::unique_ptr<ceres::CostFunction> loose_term(const Knot& about) { return std::make_unique<ceres::AutoDiffCostFunction<Loose, 6, 6>>(new Loose{about}); }

void OutlierLoss::Evaluate(double squared, double out[3]) const {
    // -2 log(exp(-s/2) + exp(-gate/2)), zero at s = 0
    const double right = 1 / (1 + std::exp(std::min(0.5 * (squared - gate_), 700.0)));
    const double at_zero = std::log1p(std::exp(-0.5 * gate_));
    out[0] = least_ * squared + 2 * at_zero +
             (squared < gate_ ? squared - 2 * std::log1p(std::exp(0.5 * (squared - gate_))) : gate_ - 2 * std::log1p(std::exp(-0.5 * (squared - gate_))));
    out[1] = least_ + right;
    out[2] = -0.5 * right * (1 - right);
}

}  // namespace roomfix
