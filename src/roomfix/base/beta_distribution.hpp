// Parts that are not known beforehand.
#pragma once

#include <cmath>

namespace roomfix {

/// log of the beta function B(a, b).
inline double log_beta(double a, double b) {
    if (b == 1) return -std::log(a);
    return std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b);
}

/// Log probability of one order of `k` samples of one kind among `n` (they need not be whole numbers), their part being of the distribution
/// Beta(a, b).
inline double log_beta_evidence(double k, double n, double a, double b) { return log_beta(a + k, b + n - k) - log_beta(a, b); }

}  // namespace roomfix
