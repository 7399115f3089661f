#include "roomfix/pipeline/zone_watch.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/random.hpp"
#include "roomfix/base/random_vector.hpp"

namespace roomfix {
namespace {

const Polyline square = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};

Fix fix_at(double x, double y, double sigma) {
    Fix fix;
    fix.robot = "r1";
    fix.status = FixStatus::ok;
    fix.pose = {x, y, 0};
    fix.covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, 0.01).asDiagonal();
    return fix;
}

TEST(ZoneWatch, ProbabilityAgreesWithDrawsBesideAStraightBorder) {
    Eigen::Matrix2d covariance;
    covariance << 0.04, 0.015, 0.015, 0.02;
    const Eigen::Vector2d place(1.9, 1.0);
    const Eigen::Matrix2d root = covariance.llt().matrixL();
    Random random(7);
    int within = 0;
    constexpr int draws = 20000;
    for (int i = 0; i < draws; ++i) {
        const Eigen::Vector2d p = place + root * normal2(random);
        within += p.x() > 0 && p.x() < 2 && p.y() > 0 && p.y() < 2;
    }
    EXPECT_NEAR(probability_within(square, place, covariance), static_cast<double>(within) / draws, 0.015);  // 4 sigma of the draws
}

TEST(ZoneWatch, NoiseAtABorderIsNoEvent) {
    ZoneWatch watch({{"dock", square}});
    EXPECT_TRUE(watch.update(fix_at(1, 1, 2)).empty());  // anywhere
    const auto entered = watch.update(fix_at(1, 1, 0.1));
    ASSERT_EQ(entered.size(), 1U);
    EXPECT_TRUE(entered[0].entered);
    EXPECT_EQ(watch.zones_of("r1"), std::vector<std::string>{"dock"});
    EXPECT_TRUE(watch.update(fix_at(2.1, 1, 0.1)).empty());  // one deviation outside
    EXPECT_TRUE(watch.update(fix_at(1.9, 1, 0.1)).empty());
    const auto left = watch.update(fix_at(2.5, 1, 0.1));
    ASSERT_EQ(left.size(), 1U);
    EXPECT_FALSE(left[0].entered);
    EXPECT_TRUE(watch.zones_of("r1").empty());
}

TEST(ZoneWatch, ALostRobotNeitherEntersNorLeaves) {
    ZoneWatch watch({{"dock", square}});
    (void)watch.update(fix_at(1, 1, 0.1));
    Fix lost = fix_at(5, 5, 0.1);
    lost.status = FixStatus::none;
    EXPECT_TRUE(watch.update(lost).empty());
    EXPECT_EQ(watch.zones_of("r1").size(), 1U);
}

TEST(ZoneWatch, ABatchTellsWhoIsWhereAndWhoIsGone) {
    ZoneWatch watch({{"hall", {{-9, -9}, {9, -9}, {9, 9}, {-9, 9}}}, {"dock", square}});
    const Fix within = fix_at(1, 1, 0.1);
    Fix thing = within;
    thing.robot = "unknown-1";
    thing.unknown = true;
    FixBatch batch{0, {within, thing}, {within, thing}};
    watch.watch(batch);
    ASSERT_EQ(batch.zone_events.size(), 2U) << "a thing that is no robot enters nothing";
    EXPECT_EQ(batch.zones_of("r1"), (std::vector<std::string>{"hall", "dock"})) << "in the order of the site file";
    EXPECT_TRUE(batch.zones_of("unknown-1").empty());
    FixBatch quiet{1, {}, {within}};  // nothing is due, and the robot stays where it is
    watch.watch(quiet);
    EXPECT_TRUE(quiet.zone_events.empty());
    EXPECT_EQ(quiet.zones_of("r1").size(), 2U);
    FixBatch gone{2, {}, {}};
    watch.watch(gone);
    ASSERT_EQ(gone.zone_events.size(), 2U);
    EXPECT_FALSE(gone.zone_events[0].entered);
    EXPECT_EQ(gone.zone_events[0].time, 2);
    EXPECT_TRUE(gone.zones_of("r1").empty());
}

TEST(ZoneWatch, ZonesThatAreDrawnAnewAreEnteredByTheNextFix) {
    ZoneWatch watch({{"dock", square}});
    (void)watch.update(fix_at(1, 1, 0.1));
    watch.set_zones({{"gate", square}, {"dock", square}});
    EXPECT_EQ(watch.zones_of("r1"), std::vector<std::string>{"dock"});
    const auto events = watch.update(fix_at(1, 1, 0.1));
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].zone, "gate");
    watch.set_zones({});
    EXPECT_TRUE(watch.zones_of("r1").empty());
}

TEST(ZoneWatch, ACornerThatPointsInwardIsOutside) {
    const Polyline arrow = {{0, 0}, {2, 1}, {0, 2}, {1, 1}};
    EXPECT_LT(probability_within(arrow, {0.5, 1}, 0.0001 * Eigen::Matrix2d::Identity()), 0.001);
    EXPECT_GT(probability_within(arrow, {1.4, 1}, 0.0001 * Eigen::Matrix2d::Identity()), 0.999);
}

}  // namespace
}  // namespace roomfix
