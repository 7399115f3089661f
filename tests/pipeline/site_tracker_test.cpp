// The library's front door: what goes in by hand, and the fixes that come out.
#include "roomfix/pipeline/site_tracker.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

namespace roomfix {
namespace {

/// Four beacons under the ceiling of a room of 8 x 6 m, and two robots that hear them.
Site beacon_room() {
    Site site;
    for (const auto& [x, y] : std::vector<std::pair<double, double>>{{0, 0}, {8, 0}, {8, 6}, {0, 6}}) {
        SiteBeacon beacon;
        beacon.id = "b" + std::to_string(site.beacons.size() + 1);
        beacon.position = {x, y, 2.5};
        site.beacons.push_back(beacon);
    }
    for (const char* id : {"r1", "r2"}) {
        SiteRobot robot;
        robot.id = id;
        robot.shape = Box{0.5, 0.4, 0.4};
        robot.receivers.emplace_back();
        robot.receivers.back().position = {0, 0, 0.5};
        site.robots.push_back(robot);
    }
    return site;
}

/// What a robot's receiver at a place of the floor measures, all at once.
RangeBatch ranges_at(const Site& site, int robot, double x, double y, Nanoseconds time) {
    RangeBatch batch;
    for (std::size_t b = 0; b < site.beacons.size(); ++b) {
        const Eigen::Vector3d& beacon = site.beacons[b].position;
        RangeObservation range{time, robot, static_cast<int>(b), (beacon - Eigen::Vector3d(x, y, 0.5)).norm(), 0.05, 0};
        batch.ranges.push_back(range);
    }
    return batch;
}

TEST(SiteTracker, FindsARobotByRangesPutInByHand) {
    auto tracker = SiteTracker::create(beacon_room());
    ASSERT_TRUE(tracker) << tracker.error().message;
    std::vector<Fix> given;
    (*tracker)->on_fixes([&](const FixBatch& batch) { given.insert(given.end(), batch.given.begin(), batch.given.end()); });
    for (int i = 0; i < 100; ++i) {
        const Nanoseconds time = 1'000'000'000 + i * 100'000'000LL;
        (*tracker)->process(ranges_at((*tracker)->site(), 0, 2 + 0.02 * i, 3, time));
    }
    ASSERT_FALSE(given.empty());
    const Fix& last = given.back();
    EXPECT_EQ(last.robot, "r1");
    EXPECT_EQ(last.status, FixStatus::ok);
    const Eigen::Vector2d error(last.pose.x - (2 + 0.02 * 99), last.pose.y - 3);
    EXPECT_LT(error.norm(), 4 * std::sqrt(last.covariance.topLeftCorner<2, 2>().trace()));
    EXPECT_LT(error.norm(), 0.1);
}

/// A listener may take its time and ask the tracker, while others feed it.
TEST(SiteTracker, ListenersAreCalledOutsideOfTheTrackersLock) {
    auto tracker = SiteTracker::create(beacon_room());
    ASSERT_TRUE(tracker);
    std::atomic<bool> calling{false};
    std::atomic<long> batches = 0, asked = 0;
    (*tracker)->on_fixes([&](const FixBatch& batch) {
        EXPECT_FALSE(calling.exchange(true)) << "one batch at a time";
        asked += static_cast<long>((*tracker)->fixes(batch.time).size());
        ++batches;
        calling = false;
    });
    const auto feed = [&](int robot) {
        for (int i = 0; i < 50; ++i) (*tracker)->process(ranges_at((*tracker)->site(), robot, 2.0 + 3 * robot, 3, 1'000'000'000 + i * 100'000'000LL));
    };
    std::thread other([&] { feed(1); });
    feed(0);
    other.join();
    EXPECT_GE(batches, 100);
    EXPECT_GT(asked, 100);
}

TEST(SiteTracker, RefusesASiteThatFindsNothing) {
    Site site = beacon_room();
    for (SiteRobot& robot : site.robots) robot.receivers.clear();
    const auto tracker = SiteTracker::create(site);
    ASSERT_FALSE(tracker);
    EXPECT_NE(tracker.error().message.find("nothing that finds robots"), std::string::npos);
    EXPECT_FALSE(SiteTracker::create(Site()));
}

}  // namespace
}  // namespace roomfix
