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
