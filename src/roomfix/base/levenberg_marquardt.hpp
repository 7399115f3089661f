// Least squares by damped steps (Levenberg 1944, Marquardt 1963): the loop that all our small problems share.
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {

/// What came of a step that was tried.
enum class StepResult {
    better,      // it was taken
    settled,     // it was taken, and was so small that it is the last one
    worse,       // it was not taken
    impossible,  // there is no step: the problem determines nothing
};

struct DampingSettings {
    double start = 1e-3;  // part that is added to the diagonal of the information
    double least = 1e-9;
    double most = 1e8;  // beyond, no step is short enough to be better
    int rounds = 100;
};

/// Calls `try_step(damping)`, which returns a StepResult, until it settles. False if a step was impossible.
template <class TryStep>
bool levenberg_marquardt(const DampingSettings& settings, TryStep&& try_step) {
    double damping = settings.start;
    for (int round = 0; round < settings.rounds && damping < settings.most; ++round) {
        switch (try_step(damping)) {
            case StepResult::better:
                damping = std::max(0.1 * damping, settings.least);
                break;
            case StepResult::settled:
                return true;
            case StepResult::worse:
                damping = std::max(10 * damping, settings.least);
                break;
            case StepResult::impossible:
                return false;
        }
    }
    return true;
}

/// The step that a damping gives: against the information (J^T W J), in the direction of the gradient (J^T W residual).
template <class Information, class Gradient>
typename Gradient::PlainObject damped_step(const Information& information, const Gradient& gradient, double damping) {
    typename Information::PlainObject damped = information;
    damped.diagonal() *= 1 + damping;
    return damped.ldlt().solve(gradient);
}

}  // namespace roomfix
