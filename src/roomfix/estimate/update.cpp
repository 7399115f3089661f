#include "roomfix/estimate/update.hpp"

#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {

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

template Surprise update<1>(Belief&, const Linearised<1>&, const Doubt&);
template Surprise update<2>(Belief&, const Linearised<2>&, const Doubt&);
template Surprise update<3>(Belief&, const Linearised<3>&, const Doubt&);
template Surprise update<5>(Belief&, const Linearised<5>&, const Doubt&);
template Surprise update<6>(Belief&, const Linearised<6>&, const Doubt&);
template Surprise update<8>(Belief&, const Linearised<8>&, const Doubt&);

}  // namespace roomfix
