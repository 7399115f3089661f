// How measured ranges err: a little in both directions, or far too long where the signal came around a corner.
#pragma once

namespace roomfix {

/// Ranges that did not come the straight way are late, never early: with probability `share` an exponential delay is added to the
/// normal noise. A few are plainly wrong, with any error up to `wrong_span` either way.
struct LateModel {
    double share = 0.10;
    double mean = 0.5;  // m, of the delay
    double wrong = 1e-3;
    double wrong_span = 20;  // m
};

/// What one error (measured - predicted, m) tells.
struct RangeLikelihood {
    double log_density = 0;  // of the error, 1/m
    double slope = 0;        // d log_density / d error, 1/m
    double curvature = 0;    // of -log_density, without what changes the causes' shares; never negative, 1/m^2
    double on_time = 0;      // probability that this range came the straight way, 0..1
};

/// `sigma` > 0: standard deviation of a range that came the straight way, m. Never infinite or NaN for finite errors.
/// Source: exponentially modified normal density (Grushka 1972) in a mixture.
RangeLikelihood range_likelihood(double error, double sigma, const LateModel& model);

/// The same for a range difference: either of its two signals may be late.
RangeLikelihood difference_likelihood(double error, double sigma, const LateModel& model);

}  // namespace roomfix
