#include "roomfix/geometry/pose.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

TEST(WrapAngle, IsTheRemainderToTheLastBit) {
    constexpr double turn = 2 * std::numbers::pi;
    Random random(11);
    for (int i = 0; i < 100000; ++i) {
        const double angle = (random.uniform() - 0.5) * (i % 2 == 0 ? 3 * turn : 100 * turn);
        EXPECT_EQ(wrap_angle(angle), std::remainder(angle, turn)) << angle;
    }
}

TEST(WrapAngle, HalfATurnIsPositive) {
    EXPECT_EQ(wrap_angle(std::numbers::pi), std::numbers::pi);
    EXPECT_EQ(wrap_angle(-std::numbers::pi), std::numbers::pi);
    EXPECT_EQ(wrap_angle(3 * std::numbers::pi), std::numbers::pi);
    EXPECT_EQ(wrap_angle(0), 0);
}

}  // namespace
}  // namespace roomfix
