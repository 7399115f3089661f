#include "roomfix/pipeline/odom_corrections.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace roomfix {
namespace {

constexpr Nanoseconds ms = 1'000'000;

/// Drives along its own x axis at 1 m/s.
OdometryObservation report_at(Nanoseconds time) { return {time, 0, {to_seconds(time), 0, 0}}; }

TEST(OdomCorrections, AFixWaitsForTheReportBehindIt) {
    OdomCorrections corrections;
    corrections.add_report(report_at(1000 * ms));
    corrections.add_fix(1050 * ms, {11.05, 5, 0});
    EXPECT_TRUE(corrections.take(1050 * ms).empty());
    corrections.add_report(report_at(1100 * ms));
    const auto taken = corrections.take(1100 * ms);
    ASSERT_EQ(taken.size(), 1U);
    EXPECT_EQ(taken[0].time, 1050 * ms);
    EXPECT_NEAR(taken[0].map_from_odom.x, 10, 1e-9);
    EXPECT_NEAR(taken[0].map_from_odom.y, 5, 1e-9);
    EXPECT_FALSE(corrections.missing_reports());
    EXPECT_TRUE(corrections.take(1200 * ms).empty());  // told once
}

TEST(OdomCorrections, AFixAtTheTimeOfAReportIsTakenAtOnce) {
    OdomCorrections corrections;
    corrections.add_report(report_at(1000 * ms));
    corrections.add_fix(1000 * ms, {1, 0, 0});
    EXPECT_EQ(corrections.take(1000 * ms).size(), 1U);
    corrections.add_fix(1000 * ms, {2, 0, 0});  // tf2 takes no second one of that time
    EXPECT_TRUE(corrections.take(1000 * ms).empty());
}

TEST(OdomCorrections, OfTwoFixesOfOneTimeTheLaterIsTaken) {
    OdomCorrections corrections;
    corrections.add_report(report_at(1000 * ms));
    corrections.add_fix(1050 * ms, {1, 0, 0});
    corrections.add_fix(1050 * ms, {3.05, 0, 0});
    corrections.add_report(report_at(1100 * ms));
    const auto taken = corrections.take(1100 * ms);
    ASSERT_EQ(taken.size(), 1U);
    EXPECT_NEAR(taken[0].map_from_odom.x, 2, 1e-9);
}

TEST(OdomCorrections, SilentWheelsAreSaid) {
    OdomCorrections corrections;
    corrections.add_report(report_at(1000 * ms));
    corrections.add_fix(1500 * ms, {1, 0, 0});
    corrections.add_fix(2500 * ms, {2, 0, 0});
    EXPECT_TRUE(corrections.take(2500 * ms).empty());
    EXPECT_FALSE(corrections.missing_reports());  // one may still come
    EXPECT_TRUE(corrections.take(2501 * ms).empty());
    EXPECT_TRUE(corrections.missing_reports());
    corrections.add_report(report_at(2600 * ms));  // too far from the one before to tell of what is between them
    EXPECT_TRUE(corrections.take(2600 * ms).empty());
    corrections.add_report(report_at(2700 * ms));
    corrections.add_fix(2650 * ms, {2.65, 0, 0});
    EXPECT_EQ(corrections.take(2700 * ms).size(), 1U);
    EXPECT_FALSE(corrections.missing_reports());
}

TEST(OdomCorrections, NothingIsMadeOfARestartedOdometry) {
    OdomCorrections corrections;
    corrections.add_report({1000 * ms, 0, {100, 0, 0}});
    corrections.add_fix(1050 * ms, {1, 0, 0});
    corrections.add_report({1100 * ms, 0, {0, 0, 0}});
    corrections.add_report({1200 * ms, 0, {std::numeric_limits<double>::quiet_NaN(), 0, 0}});
    EXPECT_TRUE(corrections.take(1200 * ms).empty());
    EXPECT_TRUE(corrections.missing_reports());
}

}  // namespace
}  // namespace roomfix
