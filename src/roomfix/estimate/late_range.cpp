#include "roomfix/estimate/late_range.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

/// One way in which the measurement can have come about: its density, and what the undelayed measurement was then.
struct Cause {
    double density = 0;
    Gaussian1 undelayed;
};

double normal_density(double error, double variance) { return std::exp(-0.5 * error * error / variance) / std::sqrt(2 * std::numbers::pi * variance); }

/// Mills' ratio Phi(t) / phi(t) of the standard normal distribution; phi(t) is exp(-t^2 / 2) / sqrt(2 pi).
double mills(double t) {
    if (t > -8) return 0.5 * std::erfc(-t / std::numbers::sqrt2) / (std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi));
    const double u = 1 / (t * t);
    return -1 / t * (1 - u * (1 - 3 * u * (1 - 5 * u)));
}

/// Late by an exponential delay: the undelayed measurement lies below `error` (from its mean), normal with variance S, tilted by the delay.
Cause late_cause(double mean, double variance, double measured, double delay) {
    const double deviation = std::sqrt(variance);
    const double error = measured - mean;
    const double t = (error - variance / delay) / deviation;
    Cause cause;
    if (t < 30) {
        const double ratio = mills(t);
        cause.density = normal_density(error, variance) * deviation * ratio / delay;
        const double hazard = 1 / ratio;
        cause.undelayed.mean = mean + variance / delay - deviation * hazard;
        cause.undelayed.variance = variance * std::max(1 - hazard * (t + hazard), 0.5 / (2 + t * t));
    } else {
        cause.density = std::exp(-error / delay + 0.5 * variance / (delay * delay)) / delay;
        cause.undelayed = {mean + variance / delay, variance};
    }
    if (!std::isfinite(cause.density)) cause.density = 0;
    return cause;
}

LatePosterior mix(const Gaussian1& prior, double measured, double sigma, const LateModel& model, bool both_ways) {
    const double variance = prior.variance + sigma * sigma;
    const double error = measured - prior.mean;
    std::array<Cause, 3> causes;
    causes[0] = {(1 - model.share - model.wrong) * normal_density(error, variance), {measured, 0}};
    const double late_share = both_ways ? 0.5 * model.share : model.share;
    causes[1] = late_cause(prior.mean, variance, measured, model.mean);
    causes[1].density *= late_share;
    if (both_ways) {
        const Cause mirrored = late_cause(-prior.mean, variance, -measured, model.mean);
        causes[2] = {late_share * mirrored.density, {-mirrored.undelayed.mean, mirrored.undelayed.variance}};
    }
    const double wrong = model.wrong / (2 * model.wrong_span);
    const double total = causes[0].density + causes[1].density + causes[2].density + wrong + 1e-300;

    // Each cause gives the true value by the same gain; plainly wrong ones leave the prior.
    const double gain = prior.variance / variance;
    LatePosterior posterior;
    double mean = wrong / total * prior.mean;
    double square = wrong / total * prior.variance;
    double means_square = 0;
    std::array<double, 3> means{};
    for (std::size_t i = 0; i < causes.size(); ++i) {
        const double weight = causes[i].density / total;
        if (weight == 0) continue;
        means[i] = prior.mean + gain * (causes[i].undelayed.mean - prior.mean);
        mean += weight * means[i];
        square += weight * (prior.variance * sigma * sigma / variance + gain * gain * causes[i].undelayed.variance);
    }
    if (wrong + 1e-300 >= total) mean = prior.mean;  // all densities vanish
    for (std::size_t i = 0; i < causes.size(); ++i) {
        if (causes[i].density > 0) means_square += causes[i].density / total * (means[i] - mean) * (means[i] - mean);
    }
    means_square += wrong / total * (prior.mean - mean) * (prior.mean - mean);
    posterior.value = {mean, square + means_square};
    posterior.log_evidence = std::log(total);
    posterior.on_time = causes[0].density / total;
    posterior.nis = error * error / variance;
    return posterior;
}

}  // namespace

LatePosterior measure_range(const Gaussian1& prior, double measured, double sigma, const LateModel& model) { return mix(prior, measured, sigma, model, false); }

LatePosterior measure_difference(const Gaussian1& prior, double measured, double sigma, const LateModel& model) {
    return mix(prior, measured, sigma, model, true);
}

}  // namespace roomfix
