#include "roomfix/observation/range_noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

/// A density at one error, with the slope and the curvature of its logarithm.
struct Density {
    double value = 0;
    double slope = 0;
    double curvature = 0;  // of -log
};

Density normal_density(double error, double sigma) {
    const double z = error / sigma;
    return {std::exp(-0.5 * z * z) / (sigma * std::sqrt(2 * std::numbers::pi)), -z / sigma, 1 / (sigma * sigma)};
}

/// Normal noise plus an exponential delay. With f its density and N the normal one, f + mean f' = N.
Density late_density(double error, double sigma, double mean) {
    const Density normal = normal_density(error, sigma);
    const double reach = (sigma / mean - error / sigma) / std::numbers::sqrt2;
    // N / f; for large reach by the asymptote of erfc, so that neither factor overflows.
    double ratio = mean / sigma * reach * std::numbers::sqrt2;
    Density late;
    if (reach > 5) {
        ratio *= 1 + 0.5 / (reach * reach);
        late.value = normal.value / ratio;
    } else {
        late.value = std::exp(0.5 * sigma * sigma / (mean * mean) - error / mean) * std::erfc(reach) / (2 * mean);
        ratio = late.value > 0 ? normal.value / late.value : 0;
    }
    late.slope = (ratio - 1) / mean;
    late.curvature = std::max(ratio / mean * (error / (sigma * sigma) + late.slope), 0.0);
    return late;
}

RangeLikelihood mixture(const Density& straight, const Density& late, const Density& early, const LateModel& model) {
    const double wrong = model.wrong / (2 * model.wrong_span);
    const double on_time = (1 - model.share - model.wrong) * straight.value;
    const double behind = 0.5 * model.share * late.value;
    const double ahead = 0.5 * model.share * early.value;
    const double all = on_time + behind + ahead + wrong + 1e-300;
    return {std::log(all), (on_time * straight.slope + behind * late.slope + ahead * early.slope) / all,
            (on_time * straight.curvature + behind * late.curvature + ahead * early.curvature) / all, on_time / all};
}

}  // namespace

RangeLikelihood range_likelihood(double error, double sigma, const LateModel& model) {
    const Density late = late_density(error, sigma, model.mean);
    return mixture(normal_density(error, sigma), late, late, model);
}

RangeLikelihood difference_likelihood(double error, double sigma, const LateModel& model) {
    Density early = late_density(-error, sigma, model.mean);
    early.slope = -early.slope;
    return mixture(normal_density(error, sigma), late_density(error, sigma, model.mean), early, model);
}

}  // namespace roomfix
