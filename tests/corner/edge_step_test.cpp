#include "roomfix/corner/edge_step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

/// A blurred step of light across a straight line, through gamma, with noise.
LumaImage step_picture(const Eigen::Vector2d& normal, double distance, double dark, double bright, double blur, double noise, Random& random) {
    LumaImage picture(160, 120);
    for (int y = 0; y < 120; ++y) {
        for (int x = 0; x < 160; ++x) {
            const double d = normal.dot(Eigen::Vector2d(x, y)) - distance;
            const double light = dark + (bright - dark) * 0.5 * std::erfc(-d / (blur * std::numbers::sqrt2));
            const double grey = 255 * std::pow(light / 255, 1 / 2.2) + random.normal(noise);
            picture.row(y)[x] = static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L));
        }
    }
    return picture;
}

LineStretch stretch_on(const Eigen::Vector2d& normal, double distance, double offset, double from, double to) {
    const Eigen::Vector2d along(normal.y(), -normal.x());
    const Eigen::Vector2d foot = (distance + offset) * normal;
    return {foot + from * along, foot + to * along};
}

TEST(EdgeStep, ACreaseIsFoundWithATrueErrorWhateverStepsAcrossIt) {
    Random random(4);
    const LightTable light;
    double squares = 0;
    constexpr int count = 400;
    for (int i = 0; i < count; ++i) {
        const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
        const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
        const Eigen::Vector2d along(normal.y(), -normal.x());
        const Eigen::Vector2d middle(80, 60);
        const double bright = random.uniform(60, 80);
        LumaImage picture = step_picture(normal, normal.dot(middle), 70, bright, 0.9, 0, random);
        for (int y = 0; y < 120; ++y) {
            for (int x = 0; x < 160; ++x) {
                const double d = normal.dot(Eigen::Vector2d(x, y) - middle) / 1.6;
                const double deeper = static_cast<double>(light[picture.row(y)[x]]) * (1 - 0.2 * std::exp(-0.5 * d * d));
                const double grey = 255 * std::pow(deeper / 255, 1 / 2.2) + random.normal(2);
                picture.row(y)[x] = static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L));
            }
        }
        const double offset = random.uniform(-0.15, 0.15);
        const LineStretch stretch = stretch_on(normal, normal.dot(middle), offset, along.dot(middle) - 12, along.dot(middle) + 12);
        LightProfile profile;
        EdgeStep step;
        ASSERT_TRUE(read_profile(picture, light, stretch, 9, 1, profile));
        ASSERT_TRUE(fit_step(profile, 1.6, 9, StepModel::crease, step));
        EXPECT_NEAR(step.contrast, -0.2 * 0.5 * (70 + bright), 5);
        const double toward = stretch.normal().dot(normal) > 0 ? 1 : -1;
        const double error = step.offset + toward * offset;
        squares += error * error / step.variance;
    }
    EXPECT_GT(squares / count, 0.75);
    EXPECT_LT(squares / count, 1.5);
}

TEST(EdgeStep, AStepIsFoundWithATrueError) {
    Random random(3);
    const LightTable light;
    double squares = 0;
    int count = 0;
    for (int i = 0; i < 400; ++i) {
        const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
        const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
        const double distance = normal.dot(Eigen::Vector2d(80, 60));
        const LumaImage picture = step_picture(normal, distance, 60, 90, 0.9, 2, random);
        const double offset = random.uniform(-0.2, 0.2);
        const double middle = Eigen::Vector2d(normal.y(), -normal.x()).dot(Eigen::Vector2d(80, 60));
        LineStretch stretch = stretch_on(normal, distance, offset, middle - 8, middle + 8);
        LightProfile profile;
        EdgeStep step;
        ASSERT_TRUE(read_profile(picture, light, stretch, 12, 1, profile));
        ASSERT_TRUE(fit_step(profile, 0.9, 12, StepModel::full, step));
        EXPECT_NEAR(std::abs(step.contrast), 30, 8);
        const double toward = stretch.normal().dot(normal) > 0 ? 1 : -1;
        const double error = step.offset + toward * offset;
        squares += error * error / step.variance;
        ++count;
    }
    // Mean square of unit normal errors over 400 readings: within 0.78 to 1.22 but for one run in 1000; the step is linear to first order.
    EXPECT_GT(squares / count, 0.75);
    EXPECT_LT(squares / count, 1.35);
}

TEST(EdgeStep, AFaintStepInADarkCreaseIsNotMovedByTheLightBesideIt) {
    Random random(17);
    const LightTable light;
    const double line = 80.3;
    const auto mean_offset = [&](StepModel model) {
        double sum = 0;
        constexpr int pictures = 60;
        for (int i = 0; i < pictures; ++i) {
            LumaImage picture(160, 120);
            for (int y = 0; y < 120; ++y) {
                for (int x = 0; x < 160; ++x) {
                    const double d = x - line;
                    const double side = 0.5 * std::erfc(-d / (0.9 * std::numbers::sqrt2));
                    const double bell = std::exp(-0.5 * d * d / 0.81) / std::sqrt(2 * std::numbers::pi);
                    const double crease = -0.3 * d + 0.8 * (d * side + 0.9 * bell);  // blurred like the step
                    const double value = 60 + crease + 8 * side;
                    picture.row(y)[x] = static_cast<std::uint8_t>(std::lround(255 * std::pow(value / 255, 1 / 2.2) + random.normal(1)));
                }
            }
            LightProfile profile;
            EdgeStep step;
            const LineStretch stretch{{line, 20}, {line, 84}};
            EXPECT_TRUE(read_profile(picture, light, stretch, 5, 1, profile));
            EXPECT_TRUE(fit_step(profile, 0.9, 5, model, step));
            sum += -step.offset;  // the normal points to the left
        }
        return sum / pictures;
    };
    // One reading is good to some 0.06 px, the mean of 60 to 0.008 px.
    EXPECT_NEAR(mean_offset(StepModel::sloped), 0, 0.05);
    EXPECT_GT(std::abs(mean_offset(StepModel::plain)), 0.1) << "else this test shows nothing";
}

TEST(EdgeStep, WhereNothingStepsTheContrastIsNoise) {
    Random random(5);
    const LumaImage picture = step_picture({1, 0}, 80, 80, 80, 0.9, 2, random);
    LightProfile profile;
    EdgeStep step;
    ASSERT_TRUE(read_profile(picture, LightTable(), {{60, 40}, {61, 80}}, 10, 1, profile));
    ASSERT_TRUE(fit_step(profile, 0.9, 10, StepModel::full, step));
    EXPECT_LT(std::abs(step.contrast), 4 * step.contrast_sigma);
}

TEST(EdgeStep, BesideThePicturesBorderOneSideIsReadLess) {
    Random random(6);
    const LumaImage picture = step_picture({1, 0}, 6, 60, 90, 0.9, 1, random);
    LightProfile profile;
    EdgeStep step;
    ASSERT_TRUE(read_profile(picture, LightTable(), {{6.1, 40}, {6.1, 70}}, 12, 1, profile));
    ASSERT_TRUE(fit_step(profile, 0.9, 12, StepModel::plain, step));
    EXPECT_NEAR(std::abs(step.offset), 0.1, 0.15);
    EXPECT_FALSE(read_profile(picture, LightTable(), {{1, 40}, {1, 70}}, 12, 1, profile));
    EXPECT_FALSE(read_profile(picture, LightTable(), {{40, 110}, {40, 130}}, 12, 1, profile));
    EXPECT_FALSE(read_profile(picture, LightTable(), {{40, 50}, {40, 50}}, 12, 1, profile));
}

}  // namespace
}  // namespace roomfix
