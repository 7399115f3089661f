#include "roomfix/imaging/bright_spots.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/imaging/spot_fit.hpp"
#include "roomfix/imaging/spot_sums.hpp"

namespace roomfix {
namespace {

LumaImage noise_image(int width, int height, std::uint64_t seed) {
    LumaImage image(width, height);
    Random random(seed);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) image.row(y)[x] = static_cast<std::uint8_t>(random.index(256));
    }
    return image;
}

TEST(BrightSpots, SimdAndScalarAgreeBitForBit) {
    const LumaImage image = noise_image(448, 40, 3);
    for (const BrightSpotSettings& settings : {BrightSpotSettings{}, {1, 1, 2}, {200, 90, 7}, {255, 255, 4}}) {
        for (int y = 8; y < 31; ++y) {
            std::uint64_t fast[6], slow[6];
            const BrightRow row{image.row(y) + 16, image.view().stride, 6, settings};
            simd::bright_row(row, fast);
            scalar::bright_row(row, slow);
            for (int w = 0; w < 6; ++w) ASSERT_EQ(fast[w], slow[w]) << y << ' ' << w;
        }
    }
}

TEST(BrightSpots, FindsSpotsAndNoTubes) {
    LumaImage image(200, 100);
    for (int y = 0; y < 100; ++y) std::memset(image.row(y), 40, 200);
    for (int y = 49; y <= 51; ++y) std::memset(image.row(y) + 20, 255, 120);  // a tube
    for (int y = 20; y <= 21; ++y) std::memset(image.row(y) + 90, 255, 2);    // a LED
    for (int y = 46; y <= 47; ++y) std::memset(image.row(y) + 60, 255, 2);    // a LED that nearly touches the tube
    BitMask spots;
    find_bright_spots(image, {}, spots);
    EXPECT_TRUE(spots.at(90, 20));
    EXPECT_TRUE(spots.at(60, 46));
    for (int x = 26; x < 134; ++x) EXPECT_FALSE(spots.at(x, 50)) << x;
    const LumaImage tiny(5, 5);
    find_bright_spots(tiny, {}, spots);
    EXPECT_EQ(spots.count(), 0);
}

TEST(SpotSums, SimdAndScalarAgree) {
    SpotPixels pixels;
    Random random(8);
    pixels.count = 64;
    for (std::size_t i = 0; i < 64; ++i) {
        pixels.x[i] = static_cast<float>(random.uniform(-4, 4));
        pixels.y[i] = static_cast<float>(random.uniform(-4, 4));
        pixels.grey[i] = static_cast<float>(random.index(256));
        pixels.weight[i] = i < 60 ? 1.0f : 0.0f;
    }
    const SpotModel model{0.3f, -0.2f, 2.0f, 0.8f, 0.05f, 0.002f, -0.001f, 2.2f, 2.3f, 0.12f, 250, 3};
    SpotSums fast, slow;
    simd::spot_sums(pixels, model, fast);
    scalar::spot_sums(pixels, model, slow);
    for (std::size_t k = 0; k < 28; ++k) EXPECT_NEAR(fast.normal[k], slow.normal[k], 1e-3f * (std::abs(slow.normal[k]) + 100)) << k;
    for (std::size_t k = 0; k < 7; ++k) EXPECT_NEAR(fast.gradient[k], slow.gradient[k], 1e-3f * (std::abs(slow.gradient[k]) + 100)) << k;
    EXPECT_NEAR(fast.cost, slow.cost, 1e-3f * slow.cost);
}

/// A Gaussian of light on a dark ground, through a response curve, with noise, cut off at 255.
LumaImage spot_image(double u, double v, double amplitude, double width, double gamma, Random& random) {
    LumaImage image(64, 32);
    for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 64; ++x) {
            const double square = (x - u) * (x - u) + (y - v) * (y - v);
            const double light = 0.02 + amplitude * std::exp(-square / (2 * width * width));
            const double grey = 255 * std::pow(light, 1 / gamma);
            image.row(y)[x] = static_cast<std::uint8_t>(std::clamp(std::lround(std::min(grey, 300.0) + random.normal(std::sqrt(1.5 + 0.12 * grey))), 0L, 255L));
        }
    }
    return image;
}

TEST(SpotFit, CentreIsTrueToItsCovarianceAlsoWhenSaturated) {
    // 600 fits of two coordinates each: mean normalised square 2 +- 0.3 has a false-alarm rate far below 1e-4.
    Random random(17);
    for (const double amplitude : {0.4, 3.0, 12.0}) {
        double sum = 0;
        double noise = 0;
        double squares = 0;
        constexpr int runs = 600;
        for (int i = 0; i < runs; ++i) {
            const double u = 30 + random.uniform();
            const double v = 15 + random.uniform();
            const auto fit = fit_spot(spot_image(u, v, amplitude, 0.8, 2.2, random), {std::round(u), std::round(v)});
            ASSERT_TRUE(fit);
            const Eigen::Vector2d e = fit->centre - Eigen::Vector2d(u, v);
            sum += e.dot(fit->covariance.inverse() * e);
            noise += fit->noise / runs;
            squares += e.squaredNorm() / 2;
        }
        EXPECT_LT(std::sqrt(squares / runs), 0.03) << amplitude;
        EXPECT_NEAR(sum / runs / noise, 2, 0.35) << amplitude;
    }
}

TEST(SpotFit, AWrongGammaMovesNothing) {
    Random random(18);
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (int i = 0; i < 200; ++i) {
        const auto fit = fit_spot(spot_image(30.3, 15.4, 2, 0.8, 1.0, random), {30, 15});
        ASSERT_TRUE(fit);
        mean += (fit->centre - Eigen::Vector2d(30.3, 15.4)) / 200;
    }
    EXPECT_LT(mean.norm(), 0.01);
}

TEST(SpotFit, RefusesWhatIsNoSpot) {
    LumaImage image(64, 32);
    EXPECT_FALSE(fit_spot(image, {30, 15})) << "dark";
    for (int y = 0; y < 32; ++y) std::memset(image.row(y), 255, 64);
    EXPECT_FALSE(fit_spot(image, {30, 15})) << "white";
    EXPECT_FALSE(fit_spot(image, {1, 1})) << "at the border";
    EXPECT_FALSE(fit_spot(image, {1e9, -1e9}));
}

}  // namespace
}  // namespace roomfix
