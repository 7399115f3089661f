// The iterated Kalman update: linearised again where the first update led, since pixels bend with the pose.
#pragma once

#include "roomfix/estimate/update.hpp"

namespace roomfix {

constexpr int most_iterations = 4;
constexpr double settled = 0.02;  // standard deviations: a smaller move changes nothing

/// `linearise(belief)` gives std::optional<Linearised<Rows>>. Nothing where it gives nothing at the belief itself.
/// Source: Bell and Cathey 1993, the iterated Kalman filter as Gauss-Newton.
template <int Rows, class Linearise>
std::optional<Innovation> iterated_update(Belief& belief, const OutlierModel& outliers, const Linearise& linearise) {
    auto measured = linearise(belief);
    if (!measured) return std::nullopt;
    Belief updated = belief;
    Innovation innovation = update(updated, *measured, outliers);
    Belief at = belief;
    for (int i = 1; i < most_iterations && innovation.right > 0.01; ++i) {
        const Eigen::Vector3d moved = updated.mean.template head<3>() - at.mean.template head<3>();
        bool still = true;
        for (int k = 0; k < 3; ++k) still = still && moved[k] * moved[k] < settled * settled * updated.covariance(k, k);
        if (still) break;
        at.mean = updated.mean;
        auto again = linearise(at);
        if (!again) break;
        // The residual as seen from the belief itself.
        for (std::size_t k = 0; k < again->states.size(); ++k) {
            const int state = again->states[k];
            again->residual -= again->by_state.col(static_cast<Eigen::Index>(k)) * (belief.mean[state] - at.mean[state]);
        }
        updated = belief;
        innovation = update(updated, *again, outliers);
    }
    belief = updated;
    return innovation;
}

}  // namespace roomfix
