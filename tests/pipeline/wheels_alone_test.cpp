// All cameras stop: robots with wheels go on, as far as these tell, and so does what ROS is told of their frames.
#include <gtest/gtest.h>

#include <vector>

#include "roomfix/base/worker_pool.hpp"
#include "roomfix/connect/ros_fix.hpp"
#include "roomfix/pipeline/odom_corrections.hpp"
#include "roomfix/pipeline/site_tracker.hpp"
#include "roomfix/simulate/scenario_renderer.hpp"

namespace roomfix {
namespace {

TEST(WheelsAlone, GoOnWithFixesAndMapFromOdomAtAnEvenRateWhenTheCamerasAreGone) {
    Scenario scenario = li2014_scenario(3);
    scenario.site.cameras.resize(1);
    auto tracker = SiteTracker::create(scenario.site);
    ASSERT_TRUE(tracker) << tracker.error().message;
    ScenarioRenderer renderer(scenario, 0, 5);
    LumaImage picture;
    BackgroundLearner learner;
    for (std::uint64_t i = 0; i < 20; ++i) {
        renderer.render_empty(i, picture);
        learner.add(picture);
    }
    (*tracker)->set_background(0, learner.learn());
    std::vector<Fix> given;
    OdomCorrections corrections;
    std::vector<OdomCorrections::Correction> told;
    (*tracker)->on_fixes([&](const FixBatch& batch) {
        for (const OdometryObservation& report : batch.odometry) corrections.add_report(report);
        for (const Fix& fix : batch.given) {
            if (fix.status == FixStatus::none) continue;
            given.push_back(fix);
            corrections.add_fix(fix.time, fix.pose);
        }
        for (const auto& correction : corrections.take(batch.time)) told.push_back(correction);
    });
    constexpr double cameras_until = 3, wheels_until = 7;  // s; a robot that was seen for two seconds is believed for four
    int frame = 0;
    for (int i = 0; i * 0.05 < wheels_until - 1; ++i) {
        const double t = 1 + 0.05 * i;
        OdometryBatch wheels;
        wheels.poses.push_back({from_seconds(t), 0, robot_pose(scenario.robots[0], t)});
        (*tracker)->process(wheels);
        if (t > cameras_until || i % 2 != 0) continue;
        renderer.render(t, static_cast<std::uint64_t>(frame++), picture);
        ASSERT_TRUE((*tracker)->process({0, {picture.view()}, from_seconds(t)}));
    }
    ASSERT_FALSE(given.empty());
    double last = 0, last_told = 0, variance = 0;
    int coasting = 0;
    for (const Fix& fix : given) {
        const double t = to_seconds(fix.time);
        if (t <= cameras_until) {
            last = t;
            continue;
        }
        EXPECT_LT(t - last, fix.status == FixStatus::coasting && coasting == 0 ? 0.5 : 0.16) << t;
        last = t;
        if (fix.status != FixStatus::coasting) continue;
        ++coasting;
        const double now = fix.covariance(0, 0) + fix.covariance(1, 1);
        EXPECT_GE(now, variance);
        variance = now;
        const Pose2 truth = robot_pose(scenario.robots[0], t);
        EXPECT_LT(std::hypot(fix.pose.x - truth.x, fix.pose.y - truth.y), 0.1 + 4 * std::sqrt(variance));
        EXPECT_TRUE(fix.velocity);
    }
    EXPECT_GE(coasting, 33);
    EXPECT_GT(last, wheels_until - 0.2);
    for (const auto& correction : told) {
        const double t = to_seconds(correction.time);
        if (last_told > cameras_until + 0.5) EXPECT_LT(t - last_told, 0.16) << t;
        last_told = t;
    }
    EXPECT_GT(last_told, wheels_until - 0.2) << "map -> odom goes on";
    EXPECT_LE(last_told, wheels_until) << "it is not dated into the future";
}

}  // namespace
}  // namespace roomfix
