#include "roomfix/observation/range_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace roomfix {
namespace {

TEST(RangeNoise, DensityAddsUpToOne) {
    const LateModel model{.share = 0.3, .mean = 0.4, .wrong = 1e-3, .wrong_span = 20};
    for (const double sigma : {0.01, 0.1, 1.0}) {
        double ranges = 0;
        double differences = 0;
        constexpr double step = 1e-3;
        for (double e = -20; e < 20; e += step) {
            ranges += step * std::exp(range_likelihood(e, sigma, model).log_density);
            differences += step * std::exp(difference_likelihood(e, sigma, model).log_density);
        }
        EXPECT_NEAR(ranges, 1, 2e-3) << sigma;
        EXPECT_NEAR(differences, 1, 2e-3) << sigma;
    }
}

TEST(RangeNoise, LateRangesAreDoubtedAndEarlyOnesAreNot) {
    const LateModel model;
    EXPECT_GT(range_likelihood(0.01, 0.02, model).on_time, 0.95);
    EXPECT_GT(range_likelihood(-0.05, 0.02, model).on_time, 0.9) << "2.5 sigma early is just noise";
    EXPECT_LT(range_likelihood(0.15, 0.02, model).on_time, 0.01) << "7 sigma late came around a corner";
    EXPECT_GT(range_likelihood(0.3, 0.02, model).log_density, range_likelihood(-0.3, 0.02, model).log_density + 3);
    EXPECT_LT(difference_likelihood(-0.3, 0.02, model).on_time, 0.01) << "either end of a difference may be late";
}

TEST(RangeNoise, SlopeIsTheDerivative) {
    const LateModel model{.share = 0.4, .mean = 0.5};
    for (const double sigma : {0.02, 0.3}) {
        for (double e = -1.5; e < 2; e += 0.037) {
            const auto numeric = [&](auto likelihood) {
                return (likelihood(e + 1e-6, sigma, model).log_density - likelihood(e - 1e-6, sigma, model).log_density) / 2e-6;
            };
            EXPECT_NEAR(range_likelihood(e, sigma, model).slope, numeric(range_likelihood), 1e-3 * (1 + std::abs(numeric(range_likelihood)))) << e;
            EXPECT_NEAR(difference_likelihood(e, sigma, model).slope, numeric(difference_likelihood), 1e-3 * (1 + std::abs(numeric(difference_likelihood))))
                << e;
            EXPECT_GE(range_likelihood(e, sigma, model).curvature, 0);
        }
    }
}

TEST(RangeNoise, StaysFiniteFarOut) {
    for (const double e : {-1e6, -100.0, -1.0, 1.0, 100.0, 1e6}) {
        for (const double sigma : {1e-4, 0.02, 50.0}) {
            EXPECT_TRUE(std::isfinite(range_likelihood(e, sigma, {}).log_density)) << e << ' ' << sigma;
            EXPECT_TRUE(std::isfinite(range_likelihood(e, sigma, {}).on_time)) << e << ' ' << sigma;
        }
    }
}

}  // namespace
}  // namespace roomfix
