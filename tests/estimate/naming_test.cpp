// Who is who among robots that look alike: what names that are still open count, beside those that have been given.
#include "roomfix/estimate/naming.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace roomfix {
namespace {

constexpr Nanoseconds now = 10'000'000'000;

/// Three rovers that look alike and count their wheels.
Site three_rovers() {
    Site site;
    for (int i = 0; i < 3; ++i) {
        SiteRobot robot;
        robot.id = "rover" + std::to_string(i + 1);
        robot.shape = Cylinder{0.3, 0.2};
        robot.odometry = WheelOdometry{};
        site.robots.push_back(robot);
    }
    return site;
}

Track track_at(double x, double y) {
    Track track;
    track.robot = 0;
    Belief belief;
    belief.mean[0] = x;
    belief.mean[1] = y;
    belief.covariance *= 1e-4;
    track.belief.hypotheses = {{belief, 0}};
    track.time = track.born = track.seen = now;
    track.sightings = 10;
    return track;
}

class ThreeRovers : public testing::Test {
protected:
    /// Seen just now as one of the robots.
    static Track named(int robot, double x, double y) {
        Track track = track_at(x, y);
        track.robot = robot;
        track.named = true;
        return track;
    }

    /// Without a name; nats by which the wheels of each of some robots explain its way.
    static Track nameless(double x, double y, const std::vector<std::pair<int, double>>& evidence) {
        Track track = track_at(x, y);
        for (const auto& [robot, nats] : evidence) track.names.push_back({named(robot, x, y), nats, now - 100'000'000, 0.5});
        return track;
    }

    void give() { give_names(state, now, group, models); }

    TrackingModels models{three_rovers(), TrackerSettings{}};  // nothing has come from their wheels yet
    Group group = groups_of(models.site.robots).front();
    GroupState state;
};

TEST_F(ThreeRovers, ANameThatCannotBeGivenYetCountsNoLessThanOneThatIs) {
    ASSERT_EQ(group.robots.size(), 3U);
    // The second robot's wheels fit as well as the third's, so that the name stays open; where the second is thought to be elsewhere it must be the third's.
    state.associations = {Association{0, 0, true, {named(0, 1, 1), nameless(3, 1, {{1, 3.0}, {2, 3.0}})}},
                          Association{0, 0, false, {named(1, 1, 1), nameless(3, 1, {{0, -6.0}, {2, 3.0}})}}};
    give();
    ASSERT_GE(state.associations.size(), 2U);
    EXPECT_FALSE(state.associations[0].tracks[1].named);
    EXPECT_TRUE(state.associations[1].tracks[1].is(2));
    EXPECT_NEAR(state.associations[0].log_weight - state.associations[1].log_weight, std::log(2), 0.01);
}

TEST_F(ThreeRovers, GivingANameChangesNoBalance) {
    const Association known{0, 0, true, {named(0, 1, 1), nameless(3, 1, {{1, 9.0}, {2, 1.0}}), nameless(5, 2, {{1, -6.0}, {2, -2.5}})}};
    state.associations = {known};
    const double open = open_names(state.associations[0], now, group, models).nats;
    give();
    double sum = 0;
    for (const Association& association : state.associations) sum += std::exp(association.log_weight - open);
    EXPECT_NEAR(sum, 1, 0.01);
    EXPECT_TRUE(state.associations[0].tracks[1].is(1));
    EXPECT_FALSE(state.associations[0].tracks[2].named);
    const double before = state.associations[0].log_weight;
    give();
    EXPECT_NEAR(state.associations[0].log_weight, before, 0.01);
}

TEST_F(ThreeRovers, WhatATrackToldStaysWhenItEnds) {
    Association association{0, 0, true, {named(0, 1, 1), nameless(3, 1, {{1, 9.0}})}};
    state.associations = {association};
    association.open = association.log_weight = open_names(association, now, group, models).nats;
    ASSERT_GT(association.open, 5);
    const double weight = association.log_weight;
    association.tracks.pop_back();
    keep_open(association, now, group, models);
    EXPECT_EQ(association.open, 0);
    EXPECT_EQ(association.log_weight, weight);
}

TEST_F(ThreeRovers, ATrackThatCanBeNoRobotCostsWhatAStrangerDoes) {
    state.associations = {Association{0, 0, true, {named(0, 1, 1), named(1, 2, 1), named(2, 3, 1), nameless(5, 1, {})}}};
    give();
    EXPECT_DOUBLE_EQ(state.associations[0].log_weight, std::log(no_robot));
    give();
    EXPECT_DOUBLE_EQ(state.associations[0].log_weight, std::log(no_robot));
}

TEST_F(ThreeRovers, WhatMovesEvenlyNeedNotBeARobotWhoseWheelsFit) {
    Track track = track_at(3, 1);
    EXPECT_EQ(way_of_stranger(track), 0);
    propose_stranger(track);
    track.names.back().evidence = 6;
    EXPECT_NEAR(way_of_stranger(track), 6 - std::log(2), 0.01);
    propose_name(track, 0, models);
    EXPECT_EQ(way_of(0, track, models), way_of_stranger(track)) << "its wheels have told nothing yet: it moves like anything";
    EXPECT_EQ(track.names.back().evidence, 0);
    track.names.pop_back();
    models.driven[1].add(now, {});
    propose_name(track, 1, models);
    EXPECT_EQ(way_of(1, track, models), way_of_stranger(track)) << "until now it moved like anything";
    EXPECT_EQ(track.names.back().evidence, way_of_stranger(track));
    track.names.back().evidence += 1;
    state.associations = {Association{0, 0, true, {named(0, 1, 1), track}}};
    const OpenNames open = open_names(state.associations[0], now, group, models);
    ASSERT_EQ(open.ways[0].robots, std::vector<int>{1});
    const auto none = std::find_if(open.ways.begin(), open.ways.end(), [](const Naming& way) { return way.robots[0] < 0; });
    ASSERT_NE(none, open.ways.end());
    EXPECT_NEAR(open.ways[0].log_weight - none->log_weight, 1 + std::log(0.97 / 2 / 0.03), 0.01);
}

TEST_F(ThreeRovers, LookingLikeOneKindSaysNothingAgainstAStranger) {
    group.kinds = {0, 0, 1};
    Track track = track_at(1, 1);
    track.as_kind = {4, -2};
    EXPECT_EQ(looks_like(track, 0, group), 0);
    EXPECT_EQ(looks_like(track, 2, group), -6);
    track.as_kind = {0, -6};
    EXPECT_EQ(looks_like(track, 0, group), 0);
    EXPECT_EQ(looks_like(track, 2, group), -6);
}

}  // namespace
}  // namespace roomfix
