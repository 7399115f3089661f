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

TEST(SlowValues, TellABeliefWhatAllThingsShareAndNothingOfOneThing) {
    const Trajectory way = steady_drive();
    const SlowState sway{SlowKind::bearing_wander, 7, -1, 0.04, 0, 5}, scale{SlowKind::range_scale, 7, 0, 0.01, 1.0 / 600, 0};
    const SlowState of_one{SlowKind::range_bias, 7, 3, 1, 1.0 / 600, 0}, elsewhere{SlowKind::range_scale, 8, 0, 0.01, 1.0 / 600, 0};
    ceres::Problem problem;
    SlowValues values(problem, Slices(way, {0, 5}), false, 0.2, nullptr);
    *values.of(sway, from_seconds(3)) = 0.1;
    *values.of(scale, from_seconds(3)) = 0.02;
    *values.of(of_one, from_seconds(3)) = *values.of(elsewhere, from_seconds(3)) = 9;
    Belief belief;
    values.add_known(belief, 7, from_seconds(3));
    ASSERT_EQ(belief.size, core_states + 2);
    const auto swayed = find_slow(belief, SlowKind::bearing_wander, 7, -1), scaled = find_slow(belief, SlowKind::range_scale, 7, 0);
    ASSERT_TRUE(swayed && scaled);
    EXPECT_EQ(belief.mean[*swayed], 0.1);
    EXPECT_LT(belief.covariance(*swayed, *swayed), sway.variance);
    EXPECT_EQ(belief.mean[*scaled], 0.02);
    Belief later;
    values.add_known(later, 7, from_seconds(15));
    EXPECT_EQ(later.size, core_states + 1) << "of the sway nothing is known then";
}

}  // namespace
}  // namespace roomfix
