// The Kalman update, with room for outliers: what every measurement model ends in.
#pragma once

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
struct OutlierModel {
    double share = 0.01;       // of the measurements that are wrong altogether
    double gate = 16;          // squared Mahalanobis distance at which right and wrong are equally likely; infinity: never wrong
    double log_density = -10;  // of a wrong one over all measurements, to weigh hypotheses
    double belongs = 1;        // probability that it is about what it is taken for
};

/// What an update did.
struct Innovation {
    double log_evidence = 0;  // log density of the measurement
    double right = 1;         // probability that it was what it seemed, 0..1
    double nis = 0;           // normalised innovation squared
    int dimensions = 0;
};

/// Mean and covariance over "right" and "wrong" (as in probabilistic data association): the covariance in Joseph's form for the
/// right part, larger where it is doubtful. Without effect, right = 0, where the innovation's covariance is not positive definite.
template <int Rows>
Innovation update(Belief& belief, const Linearised<Rows>& measured, const OutlierModel& outliers);  // Rows: 1, 2, 3, 5, 6 or 8

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
