#include "roomfix/smooth/slow_values.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

/// 0.2 m/s for 20 s.
Trajectory steady_drive() {
    Trajectory way;
    for (int i = 0; i <= 400; ++i) {
        way.times.push_back(from_seconds(0.05 * i));
        way.knots.emplace_back(Knot::Zero());
        way.knots.back().x() = 0.2 * 0.05 * i;
    }
    return way;
}

TEST(SlowValues, WhatIsAnotherAfterADecimetreIsNotTakenForConstantOverASecond) {
    const Trajectory way = steady_drive();
    const SlowState wander{SlowKind::range_wander, 0, 3, 1, 0, 1 / 0.13};
    ASSERT_TRUE(changes_fast(wander, 0.2));
    ceres::Problem problem;
    SlowValues values(problem, Slices(way, {0, wander.per_metre}), false, 0.2, nullptr);
    double* first = values.of(wander, from_seconds(2));
    EXPECT_EQ(values.of(wander, from_seconds(2.05)), first);
    EXPECT_NE(values.of(wander, from_seconds(2.3)), first);
    EXPECT_TRUE(values.all().front().slice);
    const std::size_t before = values.all().size();
    values.of(wander, from_seconds(12));
    EXPECT_EQ(values.all().size(), before + 1) << "after so long it starts anew, with nothing between";
}

TEST(SlowValues, WhatStaysIsOneUnknownThatAllSlicesShare) {
    const Trajectory way = steady_drive();
    const SlowState bias{SlowKind::range_bias, 0, 3, 1, 1.0 / 600, 0};
    ASSERT_FALSE(changes_fast(bias, 0.2));
    ceres::Problem problem;
    SlowValues values(problem, Slices(way, {0, 7.5}), false, 0.2, nullptr);
    EXPECT_EQ(values.of(bias, from_seconds(1)), values.of(bias, from_seconds(19)));
    ASSERT_EQ(values.all().size(), 1U);
    EXPECT_FALSE(values.all().front().slice);
}

TEST(SlowValues, StartWhereTheEarlierSolutionHasThem) {
    const Trajectory way = steady_drive();
    const SlowState wander{SlowKind::range_wander, 0, 3, 1, 0, 5}, bias{SlowKind::range_bias, 0, 3, 1, 1.0 / 600, 0};
    ceres::Problem first, second;
    SlowValues earlier(first, Slices(way, {0, 5}), false, 0.2, nullptr);
    for (const double t : {1.0, 1.2, 1.4}) *earlier.of(wander, from_seconds(t)) = t;
    *earlier.of(bias, 0) = 7;
    SlowValues later(second, Slices(way, {0, 5}), false, 0.2, &earlier);
    EXPECT_EQ(*later.of(wander, from_seconds(1.2)), 1.2);
    EXPECT_EQ(*later.of(bias, 0), 7);
}

}  // namespace
}  // namespace roomfix
