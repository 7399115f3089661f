#include "roomfix/estimate/update.hpp"

#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {

template <int Rows>
Innovation update(Belief& belief, const Linearised<Rows>& measured, const OutlierModel& outliers) {
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
    Square innovation_covariance = measured.noise;
    for (std::size_t k = 0; k < measured.states.size(); ++k) {
        innovation_covariance += measured.by_state.col(static_cast<Eigen::Index>(k)) * cross.row(measured.states[k]);
    }
    innovation_covariance = 0.5 * (innovation_covariance + innovation_covariance.transpose()).eval();
    Innovation innovation;
    innovation.dimensions = Rows;
    const Eigen::LLT<Square> factor(innovation_covariance);
    if (factor.info() != Eigen::Success) {
        innovation.right = 0;
        innovation.log_evidence = outliers.log_density;
        return innovation;
    }
    const Column weighted = factor.solve(measured.residual);
    innovation.nis = measured.residual.dot(weighted);
    double log_root = 0;
    const auto& lower = factor.matrixLLT();
    for (int r = 0; r < Rows; ++r) log_root += std::log(lower(r, r));
    const double log_right = -0.5 * innovation.nis - log_root - 0.5 * Rows * std::log(2 * std::numbers::pi);
    const double most = std::max(log_right, outliers.log_density);
    innovation.log_evidence = most + std::log((1 - outliers.share) * std::exp(log_right - most) + outliers.share * std::exp(outliers.log_density - most));
    innovation.right = outliers.belongs * (std::isinf(outliers.gate) ? 1 : 1 / (1 + std::exp(std::min(0.5 * (innovation.nis - outliers.gate), 700.0))));
    if (innovation.right < 1e-3) return innovation;

    // K = P H^T S^-1; P <- P - w (H P)^T K^T - w K H P + w K S K^T + w (1 - w) K r r^T K^T
    Eigen::Matrix<double, most_states, Rows> gain;
    gain.topRows(size) = factor.solve(cross.topRows(size).transpose()).transpose();
    const double w = innovation.right;
    Eigen::Matrix<double, most_states, Rows> half;  // P H^T - K S / 2, so that the whole is symmetric in both factors
    StateVector step;
    step.head(size) = gain.topRows(size) * measured.residual;
    half.topRows(size) = cross.topRows(size) - 0.5 * gain.topRows(size) * innovation_covariance;
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
    return innovation;
}

template Innovation update<1>(Belief&, const Linearised<1>&, const OutlierModel&);
template Innovation update<2>(Belief&, const Linearised<2>&, const OutlierModel&);
template Innovation update<3>(Belief&, const Linearised<3>&, const OutlierModel&);
template Innovation update<5>(Belief&, const Linearised<5>&, const OutlierModel&);
template Innovation update<6>(Belief&, const Linearised<6>&, const OutlierModel&);
template Innovation update<8>(Belief&, const Linearised<8>&, const OutlierModel&);

}  // namespace roomfix
