#include "roomfix/estimate/smoother.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

PoseObservation seen(double x, double y, double yaw, double sigma, int alike) {
    PoseObservation o;
    o.pose = {x, y, yaw};
    o.covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-4).asDiagonal();
    o.yaw_known = alike > 1;
    o.like_turns = alike;
    return o;
}

TEST(Smoother, FollowsARobotAndFindsItsFrontByItsMotion) {
    Smoother smoother({{"r1", Box{0.54, 0.54, 0.45}}});
    Random random(1);
    Fix last;
    for (int i = 0; i < 60; ++i) {
        const double t = 0.1 * i;
        // Drives along +y; the observer reports any of the four yaws.
        const auto o = seen(1 + random.normal(0.01), 0.4 * t + random.normal(0.01), wrap_angle(std::numbers::pi / 2 * random.index(4)), 0.01, 4);
        smoother.add(from_seconds(t), "hall", {o});
        const auto fixes = smoother.fixes(from_seconds(t));
        ASSERT_EQ(fixes.size(), 1U);
        last = fixes[0];
    }
    EXPECT_EQ(last.robot, "r1");
    EXPECT_NEAR(last.pose.x, 1, 0.02);
    EXPECT_NEAR(last.pose.y, 0.4 * 5.9, 0.03);
    EXPECT_NEAR(last.pose.yaw, std::numbers::pi / 2, 0.05);
}

TEST(Smoother, CoastsWithGrowingUncertaintyThenGivesUp) {
    Smoother smoother({{"r1", Cylinder{0.5, 0.5}}});
    for (int i = 0; i < 20; ++i) smoother.add(from_seconds(0.1 * i), "hall", {seen(0.05 * i, 0, 0, 0.01, 1)});
    const auto now = smoother.fixes(from_seconds(1.9));
    const auto later = smoother.fixes(from_seconds(2.7));
    ASSERT_EQ(now.size(), 1U);
    ASSERT_EQ(later.size(), 1U);
    EXPECT_EQ(later[0].status, FixStatus::coasting);
    EXPECT_GT(later[0].covariance(0, 0), 10 * now[0].covariance(0, 0));
    EXPECT_TRUE(smoother.fixes(from_seconds(10)).empty());
}

TEST(Smoother, ManyAlikeRobotsGetNumbersAndOneFalseSightingGetsNone) {
    Smoother smoother({{"cart", Cylinder{0.5, 1.7}, 0.005, true}});
    for (int i = 0; i < 10; ++i) {
        std::vector<PoseObservation> frame = {seen(0.03 * i, 0, 0, 0.05, 1), seen(3, 0.03 * i, 0, 0.05, 1)};
        if (i == 4) frame.push_back(seen(8, 8, 0, 0.05, 1));
        smoother.add(from_seconds(0.1 * i), "hall", frame);
    }
    const auto fixes = smoother.fixes(from_seconds(0.9));
    ASSERT_EQ(fixes.size(), 2U);
    EXPECT_EQ(fixes[0].robot, "cart-1");
    EXPECT_EQ(fixes[1].robot, "cart-2");
}

TEST(Smoother, OneWrongSightingDoesNotMakeTheOnlyRobotJump) {
    Smoother smoother({{"r1", Cylinder{0.5, 0.5}}});
    for (int i = 0; i < 12; ++i) {
        std::vector<PoseObservation> frame = {seen(1, 1, 0, 0.02, 1)};
        if (i == 6) frame.push_back(seen(5, 5, 0, 0.02, 1));
        smoother.add(from_seconds(0.1 * i), "hall", frame);
        const auto fixes = smoother.fixes(from_seconds(0.1 * i));
        ASSERT_EQ(fixes.size(), 1U);
        EXPECT_NEAR(fixes[0].pose.x, 1, 0.05);
    }
    // But carried away, it is believed at its new place.
    for (int i = 12; i < 30; ++i) smoother.add(from_seconds(0.1 * i), "hall", {seen(5, 5, 0, 0.02, 1)});
    const auto fixes = smoother.fixes(from_seconds(2.9));
    ASSERT_EQ(fixes.size(), 1U);
    EXPECT_NEAR(fixes[0].pose.x, 5, 0.05);
}

TEST(Smoother, AGoodPlaceIsNotLeftForADoubtfulOne) {
    Smoother smoother({{"r1", Box{0.54, 0.54, 0.45}}});
    int jumps = 0;
    for (int i = 0; i < 60; ++i) {
        const Nanoseconds t = from_seconds(0.1 * i);
        // Camera a sees it well but misses half a second; camera b takes a cart for it all the time.
        std::vector<PoseObservation> a;
        if (i < 30 || i > 35) a = {seen(1, 1, 0, 0.01, 4)};
        smoother.add(t, "a", a);
        smoother.add(t, "b", {seen(6, 1, 0, 0.10, 4)});
        for (const Fix& fix : smoother.fixes(t)) jumps += fix.pose.x > 3;
    }
    EXPECT_EQ(jumps, 0);
}

TEST(Smoother, AFarSurerPlaceIsBelievedAtOnce) {
    Smoother smoother({{"r1", Box{0.54, 0.54, 0.45}}});
    for (int i = 0; i < 20; ++i) smoother.add(from_seconds(0.1 * i), "b", {seen(6, 1, 0, 0.20, 4)});
    for (int i = 20; i < 24; ++i) {
        smoother.add(from_seconds(0.1 * i), "b", {seen(6, 1, 0, 0.20, 4)});
        smoother.add(from_seconds(0.1 * i), "up", {seen(1, 1, 0, 0.001, 1)});
    }
    const auto fixes = smoother.fixes(from_seconds(2.3));
    ASSERT_EQ(fixes.size(), 1U);
    EXPECT_NEAR(fixes[0].pose.x, 1, 0.05);
}

}  // namespace
}  // namespace roomfix
