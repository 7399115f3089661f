// What a range that may be late tells about the true distance: moments in closed form.
#pragma once

#include "roomfix/observation/range_noise.hpp"

namespace roomfix {

/// A distance before or after it was measured, as far as known.
struct Gaussian1 {
    double mean = 0;
    double variance = 0;
};

struct LatePosterior {
    Gaussian1 value;          // of the true value
    double log_evidence = 0;  // log density of the measurement
    double on_time = 0;       // probability that it came the straight way, 0..1
    double nis = 0;           // innovation squared over its variance, as if it came the straight way
};

/// `prior`: of the true range, m and m^2, variance > 0. `sigma` > 0, m. Mean and variance of the mixture over: straight, late by an
/// exponential delay, plainly wrong. Finite for finite input; the variance is positive.
/// Source: assumed density filtering; the late part is a truncated normal distribution.
LatePosterior measure_range(const Gaussian1& prior, double measured, double sigma, const LateModel& model);

/// The same for a range difference, which can be late or early.
LatePosterior measure_difference(const Gaussian1& prior, double measured, double sigma, const LateModel& model);

}  // namespace roomfix
