#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "roomfix/evaluate/ceiling_robustness.hpp"
#include "roomfix/evaluate/chou1986_experiment.hpp"
#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/detections.hpp"
#include "roomfix/evaluate/kim2011_experiment.hpp"
#include "roomfix/evaluate/li2014_experiment.hpp"

namespace roomfix {
namespace {

TEST(Consistency, NeesOfAKnownErrorAndYawModuloSymmetry) {
    const Eigen::Vector3d e = pose_error({1.1, 2, 3.3}, {1, 2.2, 0.1}, std::numbers::pi / 2);
    EXPECT_NEAR(e.z(), 3.2 - std::numbers::pi, 1e-12);
    EXPECT_NEAR(nees({0.1, -0.2, 0}, Eigen::Vector3d(0.01, 0.01, 1).asDiagonal()), 5, 1e-9);
    EXPECT_EQ(nees({0.1, 0, 0}, Eigen::Matrix3d::Zero()), std::numeric_limits<double>::infinity()) << "a zero covariance is no honest one";
}

TEST(Detections, AreMatchedOneToOneWithinTheGate) {
    DetectionCount count;
    count_frame({{0, 0}, {2, 0}, {9, 9}}, {{0.1, 0}, {0.3, 0}, {2, 0.5}}, 1.0, count);
    EXPECT_EQ(count.listed, 3);
    EXPECT_EQ(count.found, 2);
    EXPECT_EQ(count.missed, 1);
    EXPECT_EQ(count.false_ones, 1);
    EXPECT_NEAR(summarise(count.errors).max, 0.5, 1e-12);
}

TEST(Li2014, TheRecomputedErrorsAreThoseOfTheTablesCoordinates) {
    const auto& points = li2014_test_points();
    ASSERT_EQ(points.size(), 15U);
    EXPECT_NEAR((points[2].measured - points[2].actual).norm(), 0.0608, 1e-4);
    EXPECT_NEAR((points[9].measured - points[9].actual).norm(), 0.1432, 1e-4);
}

// A smaller version of the accuracy figures; the whole is in `./dev bench`. Seeds of their own.
TEST(Li2014, AHiddenRobotIsFoundOrTheCovarianceSaysSo) {
    const auto report = run_li2014({.seed = 311, .seeds = 1, .hidden = 0.3, .published = false, .board = {.shots = 0}});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_LE(report->lost(), 1);
    const Summary ours = summarise(report->position_errors());
    EXPECT_LT(ours.median, 0.02);
    EXPECT_LT(ours.mean, 0.06) << "a few of fifteen may be decimetres off ...";
    int surprises = 0;
    for (const auto& t : report->trials) surprises += t.ours && nees(t.error, t.covariance) > 25;
    EXPECT_LE(surprises, 1) << "... but then their covariance says so";
}

TEST(Li2014, OursIsAnOrderOfMagnitudeBetterAndSaysHowGoodItIs) {
    const auto report = run_li2014({.seed = 301, .seeds = 2, .fixes_per_point = 2, .board = {.shots = 0}});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->lost(), 0);
    const Summary ours = summarise(report->position_errors());
    const Summary published = summarise(report->published_errors());
    EXPECT_LT(ours.mean, 0.015);
    EXPECT_LT(ours.median, 0.010);
    EXPECT_LT(degrees(summarise(report->yaw_errors()).median), 1.0);
    EXPECT_GT(published.mean, 10 * ours.median) << "the published method is the baseline, not a straw man: it finds every robot";
    EXPECT_EQ(published.count, 60U);
    // NEES of three unknowns has a median of 2.37; a few gross errors do not move it.
    std::vector<double> nees_values;
    for (const auto& t : report->trials) nees_values.push_back(nees(t.error, t.covariance));
    const double median = summarise(nees_values).median;
    EXPECT_GT(median, 0.8);
    EXPECT_LT(median, 4.5);
    EXPECT_NE(li2014_table(*report).find("as published"), std::string::npos);
}

// Smaller versions of `./dev bench`, with seeds of their own.
TEST(Kim2011, OursIsNearTheBoundAndSaysHowGoodItIs) {
    const auto report = run_kim2011({.seed = 501, .seeds = 1, .samples = 20, .board = {.shots = 0}});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->lost(), 0);
    EXPECT_LT(report->ours_rmse(), 0.0010) << "m";
    EXPECT_LT(degrees(report->yaw_rms()), 0.10);
    EXPECT_LT(report->ours_rmse(), 1.4 * report->bound_rmse());
    // 120 fixes of three unknowns: 3 +- 0.87 has a false-alarm rate of 1e-4.
    EXPECT_NEAR(report->mean_nees(), 3, 0.87);
    EXPECT_GT(report->published_rmse(), 20 * report->ours_rmse());
    EXPECT_LT(report->published_rmse(), 0.10) << "the published method is the baseline, not a straw man";
    EXPECT_GT(report->trilateration_rmse(), 0.01);
    EXPECT_LT(report->trilateration_rmse(), 0.10);
    const std::string table = kim2011_table(*report);
    EXPECT_NE(table.find("mean 2.158, root mean square 2.271 (printed 2.366)"), std::string::npos) << "the paper's headline figure, recomputed";
}

TEST(Kim2011, ATiltedMountIsCalibratedAndLateRangesDoNotMatter) {
    const auto tilted = run_kim2011({.seed = 511, .seeds = 2, .samples = 4, .tilt = radians(0.5), .baselines = false, .board = {.shots = 0}});
    ASSERT_TRUE(tilted) << tilted.error().message;
    EXPECT_EQ(tilted->lost(), 0);
    EXPECT_LT(tilted->ours_rmse(), 0.002) << "m; an uncalibrated tilt of half a degree would be 2.4 cm";
    const auto straight = run_kim2011({.seed = 521, .seeds = 1, .samples = 4, .baselines = false, .board = {.shots = 0}});
    const auto late = run_kim2011({.seed = 521, .seeds = 1, .samples = 4, .late = 0.3, .baselines = false, .board = {.shots = 0}});
    ASSERT_TRUE(straight && late);
    EXPECT_NEAR(late->ours_rmse() / straight->ours_rmse(), 1, 0.1);
}

TEST(Kim2011, LampsNeitherHideALandmarkNorMakeOne) {
    const CeilingRobustness with = run_with_lamps(150, 531);
    EXPECT_GE(with.right, 147) << with.first_miss;
    EXPECT_EQ(with.wrong, 0);
    EXPECT_EQ(run_without_landmark(200, 532).wrong, 0);
}

TEST(Consistency, FixesThatShareACalibrationCountAsOne) {
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(5, 5);
    const std::vector<StatedError> alone(100, {unit, Eigen::MatrixXd::Zero(5, 1), 0});
    const NeesBand narrow = mean_nees_band(alone);  // 5 -+ 1.96 sqrt(2 * 5 / 100)
    EXPECT_NEAR(narrow.low, 4.38, 0.08);
    EXPECT_NEAR(narrow.high, 5.62, 0.08);
    const std::vector<StatedError> together(100, {1e-6 * unit, unit, 0});
    const NeesBand wide = mean_nees_band(together);  // chi-square, 5 unknowns
    EXPECT_NEAR(wide.low, 0.83, 0.12);
    EXPECT_NEAR(wide.high, 12.83, 1);
}

TEST(Chou1986Experiment, OursComesNearTheBoundAndSaysHowWellItKnows) {
    const auto report = run_chou1986({.seed = 611, .board = {.shots = 0}});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->lost(), 0);
    // ./dev bench shows the figures of docs/chou1986.md at ten times the length; here with room for one run in 1000.
    EXPECT_LT(report->mean_error(), 0.0006);
    EXPECT_LT(report->mean_rotation(), radians(0.03));
    EXPECT_LT(report->rms_error(), 1.9 * report->bound_rms());
    EXPECT_NEAR(report->mean_nees(), 5, 1.3);
    EXPECT_NEAR(report->nees_band().low, 5 - 1.96 * std::sqrt(2.0 * 5 / 96), 0.1) << "the lens is known";
    EXPECT_LT(report->published_mean_error(), 0.05);
    EXPECT_GT(report->published_mean_error(), 2 * report->mean_error());
    EXPECT_NE(chou1986_table(*report).find("as published: "), std::string::npos);
}

// The goals of the papers' pages hold with lenses that were calibrated from rendered pictures of a board, and poses and mounts that were found with them.
TEST(Reproduce, StartsFromCalibrationPictures) {
    constexpr int shots = 15;
    const auto li = run_li2014({.seed = 321, .seeds = 1, .published = false, .board = {.shots = shots}});
    ASSERT_TRUE(li) << li.error().message;
    EXPECT_EQ(li->lost(), 0);
    EXPECT_LT(summarise(li->position_errors()).mean, 0.015);
    const auto kim = run_kim2011({.seed = 541, .seeds = 1, .samples = 4, .baselines = false, .board = {.shots = shots}});
    ASSERT_TRUE(kim) << kim.error().message;
    EXPECT_EQ(kim->lost(), 0);
    EXPECT_LT(kim->ours_rmse(), 0.002);
    EXPECT_LT(kim->mean_nees(), 12) << "one calibration decides";
    const auto chou = run_chou1986({.seed = 621, .published = false, .board = {.shots = shots}});
    ASSERT_TRUE(chou) << chou.error().message;
    EXPECT_EQ(chou->lost(), 0);
    EXPECT_LT(chou->mean_error(), 0.0008);
    EXPECT_GT(chou->nees_band().high, 6) << "one calibration decides";
    EXPECT_LT(chou->mean_nees(), 1.5 * chou->nees_band().high);
}

TEST(Chou1986Experiment, TheErrorStudyShowsWhatThePaperConcludes) {
    const LineChart chart = chou1986_error_study();
    ASSERT_EQ(chart.curves.size(), 4u);
    const auto at = [&](std::size_t curve, double x) {
        for (const auto& p : chart.curves[curve].points) {
            if (std::abs(p.x() - x) < 0.02) return p.y();
        }
        return 0.0;
    };
    // Close to the Y-Z plane Y_c suffers more from the lines' angles than X_c does, and more than farther away from it.
    EXPECT_GT(at(1, 0.5), at(1, 1.5));
    // The image centre matters less than the lines' angles.
    EXPECT_LT(at(3, 0.5), at(1, 0.5));
    const std::string svg = svg_of(chart);
    EXPECT_NE(svg.find("</svg>"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
