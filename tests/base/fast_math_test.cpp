#include "roomfix/base/fast_math.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

TEST(FastMath, ExponentialIsAsGoodAsStated) {
    double worst = 0;
    for (double x = -86; x < 87; x += 0.0137) {
        const auto f = static_cast<float>(x);
        worst = std::max(worst, std::abs(static_cast<double>(fast_exp(f)) / std::exp(static_cast<double>(f)) - 1));
    }
    EXPECT_LT(worst, 1e-5);
    EXPECT_GE(fast_exp(-1000.0f), 0.0f);
    EXPECT_TRUE(std::isfinite(fast_exp(1000.0f)));
}

TEST(FastMath, LogarithmIsAsGoodAsStated) {
    double worst = 0;
    for (double x = -80; x < 80; x += 0.0137) {
        const auto f = static_cast<float>(std::exp(x));
        worst = std::max(worst, std::abs(static_cast<double>(fast_log(f)) - std::log(static_cast<double>(f))) / std::max(1.0, std::abs(x)));
    }
    EXPECT_LT(worst, 3e-6);
}

}  // namespace
}  // namespace roomfix
