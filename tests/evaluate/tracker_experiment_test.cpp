// The tracker's promises on a smaller scale; the whole runs in the benchmarks.
#include "roomfix/evaluate/tracker_experiment.hpp"

#include <gtest/gtest.h>

#include "roomfix/evaluate/identity_experiment.hpp"

namespace roomfix {
namespace {

class Consistency : public testing::TestWithParam<int> {};

/// False alarm: once in a thousand for each set of senses (band of 3.3 standard deviations), were the seeds drawn anew.
TEST_P(Consistency, StatedCovariancesAreTrueAndErrorsNearTheBound) {
    const auto [name, senses] = all_senses()[static_cast<std::size_t>(GetParam())];
    const ConsistencyResult r = measure_consistency(name, senses, 12, 11);
    const double wider = 3.3 / 1.96;
    EXPECT_GT(r.nees, r.dimensions - wider * (r.nees_high - r.dimensions)) << name;
    EXPECT_LT(r.nees, r.dimensions + wider * (r.nees_high - r.dimensions)) << name;
    EXPECT_LT(r.rmse, 1.35 * r.bound) << name;
    EXPECT_LT(r.lost, 0.02 * r.samples) << name;
}

INSTANTIATE_TEST_SUITE_P(AllSenses, Consistency, testing::Range(0, 10));

class Smoothing : public testing::TestWithParam<int> {};

TEST_P(Smoothing, KnowsMoreThanTheTrackerAndStatesItTruly) {
    const auto [name, senses] = all_senses()[static_cast<std::size_t>(GetParam())];
    const int runs = 10;
    const ConsistencyResult tracked = measure_consistency(name, senses, runs, 12);
    const ConsistencyResult smoothed = measure_consistency(name, senses, runs, 12, {}, true);
    const double wider = 3.3 / 1.96;
    EXPECT_GT(smoothed.nees, smoothed.dimensions - wider * (smoothed.nees_high - smoothed.dimensions)) << name;
    EXPECT_LT(smoothed.nees, smoothed.dimensions + wider * (smoothed.nees_high - smoothed.dimensions)) << name;
    EXPECT_LT(smoothed.rmse, 0.97 * tracked.rmse) << name;
    EXPECT_LE(smoothed.lost, tracked.lost) << name;
}

// Sets with a hundred landmarks and everything else at once take long: they belong to the benchmarks.
INSTANTIATE_TEST_SUITE_P(AllSenses, Smoothing, testing::Values(0, 1, 2, 3, 5, 7, 8));

/// 30 drives, 360 numbers; at full length (./dev bench) 96.5 % are inside, and the mean is 4.8.
TEST(SiteCalibration, DrivesCalibrateAllCamerasAndTheStatedCovarianceIsTrue) {
    HallSenses senses;
    senses.cameras = senses.odometry = true;
    const SiteCalibrationResult r = measure_site_calibration("cameras and wheels", senses, 20, 30, 5);
    EXPECT_EQ(r.cameras, 60);
    EXPECT_GE(r.coverage, 0.88);
    EXPECT_LT(r.nees, 8);
    EXPECT_LT(r.turn_now, 0.7 * r.turn_before);
}

TEST(BlindArea, TheTruePlaceStaysInsideTheEllipseOnOdometryAlone) { EXPECT_GE(blind_coverage(60, 3, 0.01, 0.01745), 0.87); }

TEST(LookAlikes, KeepTheirNamesThroughCrossingsWithTheirWheels) {
    const CrossingResult r = simulate_crossings(40, true, 9);
    EXPECT_EQ(r.lost, 0);
    EXPECT_LE(r.switches, 1);
    EXPECT_EQ(r.flagged, r.switches);
    EXPECT_LE(r.false_alarms, 2);
}

TEST(LikeCorners, TheRightOneIsKnownAfterTwoMetres) {
    const CornerChoiceResult r = choose_among_corners(60, 9);
    EXPECT_GE(r.right, 59);
    EXPECT_LT(r.right_at_once, 50) << "the corners must look alike for this to mean something";
}

TEST(Kidnapping, IsNoticedWithinTwoSeconds) {
    const KidnappingResult r = simulate_kidnappings(60, 9);
    EXPECT_EQ(r.found, r.runs);
}

}  // namespace
}  // namespace roomfix
