#include "roomfix/estimate/late_range.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

/// Moments by adding up prior times likelihood over a fine grid.
LatePosterior by_integration(const Gaussian1& prior, double measured, double sigma, const LateModel& model, bool both_ways) {
    const double spread = std::sqrt(prior.variance);
    double sum = 0, mean = 0, square = 0;
    const double step = std::min(spread, sigma) / 200;
    for (double value = prior.mean - 12 * spread; value < prior.mean + 12 * spread; value += step) {
        const double e = measured - value;
        const double normal = std::exp(-0.5 * e * e / (sigma * sigma)) / (sigma * std::sqrt(2 * std::numbers::pi));
        const auto late = [&](double error) {
            return 0.5 / model.mean * std::exp(0.5 * sigma * sigma / (model.mean * model.mean) - error / model.mean) *
                   std::erfc((sigma / model.mean - error / sigma) / std::numbers::sqrt2);
        };
        const double delayed = both_ways ? 0.5 * (late(e) + late(-e)) : late(e);
        const double likelihood = (1 - model.share - model.wrong) * normal + model.share * delayed + model.wrong / (2 * model.wrong_span);
        const double p = likelihood * std::exp(-0.5 * (value - prior.mean) * (value - prior.mean) / prior.variance) /
                         std::sqrt(2 * std::numbers::pi * prior.variance) * step;
        sum += p;
        mean += p * value;
        square += p * value * value;
    }
    mean /= sum;
    return {{mean, square / sum - mean * mean}, std::log(sum), 0, 0};
}

TEST(LateRange, MomentsAreThoseOfNumericalIntegration) {
    const LateModel model{0.1, 0.5, 1e-3, 20};
    for (const double spread : {0.01, 0.05, 0.5}) {
        for (const double error : {-0.3, -0.05, 0.0, 0.03, 0.2, 0.8, 2.0}) {
            for (const bool both_ways : {false, true}) {
                const Gaussian1 prior{5, spread * spread};
                const auto ours = both_ways ? measure_difference(prior, 5 + error, 0.03, model) : measure_range(prior, 5 + error, 0.03, model);
                const auto exact = by_integration(prior, 5 + error, 0.03, model, both_ways);
                EXPECT_NEAR(ours.value.mean, exact.value.mean, 1e-5) << spread << " " << error;
                EXPECT_NEAR(ours.value.variance, exact.value.variance, 1e-4 * exact.value.variance + 1e-9) << spread << " " << error;
                EXPECT_NEAR(ours.log_evidence, exact.log_evidence, 1e-3) << spread << " " << error;
            }
        }
    }
}

TEST(LateRange, StaysFiniteForAnyFiniteInput) {
    for (const double variance : {1e-12, 1e-4, 1.0, 1e6}) {
        for (const double measured : {-1e6, -30.0, 0.0, 5.0, 5.1, 50.0, 1e6}) {
            for (const double sigma : {1e-6, 0.02, 100.0}) {
                const auto p = measure_range({5, variance}, measured, sigma, {});
                EXPECT_TRUE(std::isfinite(p.value.mean) && std::isfinite(p.value.variance) && std::isfinite(p.log_evidence))
                    << variance << " " << measured << " " << sigma;
                EXPECT_GT(p.value.variance, 0);
            }
        }
    }
}

TEST(LateRange, ALateOneMovesLittleAndAnEarlyOneIsBelieved) {
    const Gaussian1 prior{5, 0.1 * 0.1};
    const auto late = measure_range(prior, 6.5, 0.03, {});
    EXPECT_NEAR(late.value.mean, 5, 0.05);
    EXPECT_LT(late.on_time, 1e-6);
    const auto early = measure_range(prior, 4.85, 0.03, {});
    EXPECT_NEAR(early.value.mean, 4.86, 0.02);
}

}  // namespace
}  // namespace roomfix
