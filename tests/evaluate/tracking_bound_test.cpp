#include "roomfix/evaluate/tracking_bound.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/random.hpp"
#include "roomfix/evaluate/hall.hpp"

namespace roomfix {
namespace {

constexpr double sigma = 0.01;  // m and rad

/// A robot that drives straight ahead, seen ten times a second.
struct Drive {
    Site site = hall_site({true, false, false, false, false});
    Tracker tracker{site, {}};
    Truth truth;
    std::vector<Fix> fixes;

    Drive() {
        tracker.keep_history();
        Random random(4);
        for (int i = 0; i <= 100; ++i) {
            const Nanoseconds time = from_seconds(0.1 * i);
            const Pose2 pose{2 + 0.03 * i, 3, 0};
            truth[site.robots[0].id].push_back({time, pose});
            PoseObservation seen;
            seen.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
            seen.pose = {pose.x + random.normal(sigma), pose.y + random.normal(sigma), random.normal(sigma)};
            tracker.observe(time, site.cameras[static_cast<std::size_t>(i % 2)].id, {&seen, 1});
            const auto now = tracker.fixes(time);
            fixes.insert(fixes.end(), now.begin(), now.end());
        }
    }
};

TEST(TrackingBound, IsWhatATruthfulTrackerStatesWhereTheModelsAreNearlyLinear) {
    const Drive drive;
    const auto bounds = tracking_bounds(drive.tracker, drive.fixes, drive.truth);
    ASSERT_EQ(bounds.size(), drive.fixes.size());
    ASSERT_GT(drive.fixes.size(), 90U);
    for (std::size_t i = 30; i < bounds.size(); ++i) {
        ASSERT_TRUE(bounds[i]);
        const double bound = bounds[i]->topLeftCorner<2, 2>().trace(), stated = drive.fixes[i].covariance.topLeftCorner<2, 2>().trace();
        EXPECT_NEAR(stated / bound, 1, 0.25) << i;
        EXPECT_LT(bound, 2 * sigma * sigma);  // better than one observation alone
    }
}

TEST(TrackingBound, IsNearlyTheSameWhereTheTruthIsAnotherPointWithoutAYaw) {
    const Drive drive;
    const Eigen::Vector2d point(0.2, 0.1);
    Truth truth = drive.truth;
    for (StampedPose& pose : truth.begin()->second) pose = {pose.time, {pose.pose.x + point.x(), pose.pose.y + point.y(), 0}, false};
    const auto known = tracking_bounds(drive.tracker, drive.fixes, drive.truth), guessed = tracking_bounds(drive.tracker, drive.fixes, truth, {}, point);
    for (std::size_t i = 30; i < known.size(); ++i) {
        ASSERT_TRUE(known[i] && guessed[i]);
        const auto place_variance = [](const Eigen::Matrix3d& covariance) { return covariance(0, 0) + covariance(1, 1); };
        EXPECT_NEAR(place_variance(*guessed[i]) / place_variance(*known[i]), 1, 0.02) << i;
    }
}

TEST(TrackingBound, SaysNothingAboutARobotWithoutATruth) {
    const Drive drive;
    for (const auto& bound : tracking_bounds(drive.tracker, drive.fixes, {})) EXPECT_FALSE(bound);
    const Truth one_moment{{drive.site.robots[0].id, {{0, {}}}}};
    for (const auto& bound : tracking_bounds(drive.tracker, drive.fixes, one_moment)) EXPECT_FALSE(bound);
}

TEST(TrackingBound, ARangeThatMayBeLateTellsLess) {
    const Drive drive;
    TrackingBound bound(drive.tracker.models(), 0, [](Nanoseconds) { return StateVector(StateVector::Zero()); });
    const double sometimes = bound.range_information(0.05, {0.1, 0.5});
    EXPECT_LT(sometimes, 1 / (0.05 * 0.05));
    EXPECT_GT(sometimes, 0.7 / (0.05 * 0.05));
}

}  // namespace
}  // namespace roomfix
