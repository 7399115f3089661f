// The Kalman update, with room for outliers: what every measurement model ends in.
#pragma once

#include <Eigen/Cholesky>
#include <cmath>

#include "roomfix/estimate/belief.hpp"
#include "roomfix/estimate/late_range.hpp"

namespace roomfix {

constexpr std::size_t most_columns = 20;

/// A measurement of `Rows` numbers, linearised at a belief.
template <int Rows>
struct Linearised {
    Eigen::Matrix<double, Rows, 1> residual = Eigen::Matrix<double, Rows, 1>::Zero();  // measured - predicted
    Eigen::Matrix<double, Rows, Rows> noise = Eigen::Matrix<double, Rows, Rows>::Zero();
    FixedList<int, most_columns> states;                                                                     // the states that the prediction depends on ...
    Eigen::Matrix<double, Rows, most_columns> by_state = Eigen::Matrix<double, Rows, most_columns>::Zero();  // ... and its derivatives, one column each

    void depends(int state, const Eigen::Matrix<double, Rows, 1>& derivative) {
        by_state.col(static_cast<Eigen::Index>(states.size())) = derivative;
        states.push_back(state);
    }
    /// The same for an error whose present estimate is not yet in the residual.
    void depends_on_slow(const Belief& belief, int state, const Eigen::Matrix<double, Rows, 1>& derivative) {
        depends(state, derivative);
        residual -= derivative * belief.mean[state];
    }
    /// An error of unit variance: a slow state where the belief has one for it, noise otherwise.
    void depends_on_error(const Belief& belief, SlowKind kind, int source, int component, const Eigen::Matrix<double, Rows, 1>& derivative) {
        if (const auto slow = find_slow(belief, kind, source, component)) {
            depends_on_slow(belief, *slow, derivative);
        } else {
            noise += derivative * derivative.transpose();
        }
    }
};

/// How a measurement may be something else than what it seems.
struct Doubt {
    double share = 0.01;       // of the measurements that are wrong altogether
    double gate = 16;          // squared Mahalanobis distance at which right and wrong are equally likely; infinity: never wrong
    double log_density = -10;  // of a wrong one over all measurements, to weigh hypotheses
    double belongs = 1;        // probability that it is about what it is taken for
};

/// What an update did.
struct Surprise {
    double log_evidence = 0;  // log density of the measurement
    double right = 1;         // probability that it was what it seemed, 0..1
    double nis = 0;           // normalised innovation squared
    int dimensions = 0;
};

/// Mean and covariance over "right" and "wrong" (as in probabilistic data association): the covariance in Joseph's form for the
/// right part, larger where it is doubtful. Without effect, right = 0, where the innovation's covariance is not positive definite.
template <int Rows>
Surprise update(Belief& belief, const Linearised<Rows>& measured, const Doubt& doubt) {
    using Column = Eigen::Matrix<double, Rows, 1>;
    using Square = Eigen::Matrix<double, Rows, Rows>;
    const int size = belief.size;
    Eigen::Matrix<double, most_states, Rows> cross;  // P H^T
    cross.topRows(size).setZero();
    for (std::size_t k = 0; k < measured.states.size(); ++k) {
        const auto from = belief.covariance.col(measured.states[k]).head(size);
        const auto column = measured.by_state.col(static_cast<Eigen::Index>(k));
        for (int r = 0; r < Rows; ++r) cross.col(r).head(size) += column[r] * from;
    }
    Square innovation = measured.noise;
    for (std::size_t k = 0; k < measured.states.size(); ++k) {
        innovation += measured.by_state.col(static_cast<Eigen::Index>(k)) * cross.row(measured.states[k]);
    }
    innovation = 0.5 * (innovation + innovation.transpose()).eval();
    Surprise surprise;
    surprise.dimensions = Rows;
    const Eigen::LLT<Square> factor(innovation);
    if (factor.info() != Eigen::Success) {
        surprise.right = 0;
        surprise.log_evidence = doubt.log_density;
        return surprise;
    }
    const Column weighted = factor.solve(measured.residual);
    surprise.nis = measured.residual.dot(weighted);
    double log_root = 0;
    const auto& lower = factor.matrixLLT();
    for (int r = 0; r < Rows; ++r) log_root += std::log(lower(r, r));
    const double log_right = -0.5 * surprise.nis - log_root - 0.5 * Rows * std::log(2 * std::numbers::pi);
    const double most = std::max(log_right, doubt.log_density);
    surprise.log_evidence = most + std::log((1 - doubt.share) * std::exp(log_right - most) + doubt.share * std::exp(doubt.log_density - most));
    surprise.right = doubt.belongs * (std::isinf(doubt.gate) ? 1 : 1 / (1 + std::exp(std::min(0.5 * (surprise.nis - doubt.gate), 700.0))));
    if (surprise.right < 1e-3) return surprise;

    // K = P H^T S^-1; P <- P - w (H P)^T K^T - w K H P + w K S K^T + w (1 - w) K r r^T K^T
    Eigen::Matrix<double, most_states, Rows> gain;
    gain.topRows(size) = factor.solve(cross.topRows(size).transpose()).transpose();
    const double w = surprise.right;
    Eigen::Matrix<double, most_states, Rows> half;  // P H^T - K S / 2, so that the whole is symmetric in both factors
    StateVector step;
    step.head(size) = gain.topRows(size) * measured.residual;
    half.topRows(size) = cross.topRows(size) - 0.5 * gain.topRows(size) * innovation;
    belief.mean.head(size) += w * step.head(size);
    auto& p = belief.covariance;
    for (int j = 0; j < size; ++j) {
        for (int i = 0; i <= j; ++i) {
            double less = 0;
            for (int r = 0; r < Rows; ++r) less += half(i, r) * gain(j, r) + gain(i, r) * half(j, r);
            p(i, j) += w * ((1 - w) * step[i] * step[j] - less);
            p(j, i) = p(i, j);
        }
    }
    return surprise;
}

/// One number whose distribution is not normal: `measure` turns what is believed of the predicted value into what is believed of it
/// afterwards. The state follows by its correlation with it.
template <class Measure>
LatePosterior update_scalar(Belief& belief, double predicted, const FixedList<int, most_columns>& states,
                            const Eigen::Matrix<double, 1, most_columns>& by_state, const Measure& measure) {
    const int size = belief.size;
    StateVector cross;
    cross.head(size).setZero();
    for (std::size_t k = 0; k < states.size(); ++k) cross.head(size) += by_state[static_cast<Eigen::Index>(k)] * belief.covariance.col(states[k]).head(size);
    double variance = 0;
    for (std::size_t k = 0; k < states.size(); ++k) variance += by_state[static_cast<Eigen::Index>(k)] * cross[states[k]];
    variance = std::max(variance, 1e-18);
    const LatePosterior posterior = measure(Gaussian1{predicted, variance});
    const double shift = (posterior.value.mean - predicted) / variance;
    const double shrink = (posterior.value.variance - variance) / (variance * variance);
    belief.mean.head(size) += shift * cross.head(size);
    auto& p = belief.covariance;
    for (int j = 0; j < size; ++j) {
        const double part = shrink * cross[j];
        for (int i = 0; i <= j; ++i) p(i, j) += part * cross[i];
        for (int i = 0; i < j; ++i) p(j, i) = p(i, j);
    }
    return posterior;
}

}  // namespace roomfix
