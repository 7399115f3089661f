// Sightings of landmarks by robots' own detectors, from files.
#include "roomfix/connect/sighting_source.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

Site site_with_posts() {
    Site site;
    site.robots.resize(2);
    site.robots[0].id = "r1";
    site.robots[1].id = "r2";
    site.robots[1].detector = Detector{.range_sigma = 0.3, .bearing_sigma = 0.04};
    site.landmarks = {{"post1", PointMark{}}, {"post2", PointMark{}}};
    return site;
}

TEST(SightingSource, ReadsRangeAndBearingOrEitherAlone) {
    const auto batch =
        parse_sightings("bearing,time,landmark,robot,range,range_sigma\n0.5,1.25,post2,r1,2.5,0.1\n,1.5,post1,r2,3,\n-0.2,1.75,,r1,,\n", site_with_posts(), -1);
    ASSERT_TRUE(batch) << batch.error().message;
    EXPECT_TRUE(batch->problems.empty());
    ASSERT_EQ(batch->sightings.size(), 3U);
    const auto& both = batch->sightings[0];
    EXPECT_EQ(both.time, 1'250'000'000);
    EXPECT_EQ(both.landmark, 1);
    EXPECT_DOUBLE_EQ(both.range.value(), 2.5);
    EXPECT_DOUBLE_EQ(both.bearing.value(), 0.5);
    EXPECT_DOUBLE_EQ(both.range_sigma, 0.1);
    EXPECT_DOUBLE_EQ(both.bearing_sigma, Detector{}.bearing_sigma);
    EXPECT_FALSE(batch->sightings[1].bearing);
    EXPECT_EQ(batch->sightings[1].robot, 1);
    EXPECT_DOUBLE_EQ(batch->sightings[1].range_sigma, 0.3) << "the detector's own";
    EXPECT_EQ(batch->sightings[2].landmark, -1) << "nobody says which";
    EXPECT_FALSE(batch->sightings[2].range);
}

TEST(SightingSource, ReadsJsonLinesAmongOthers) {
    const auto batch = parse_sightings("# a comment\n{\"time\": 2, \"landmark\": \"post1\", \"range\": 3.5, \"bearing\": null}\n", site_with_posts(), 0);
    ASSERT_TRUE(batch);
    ASSERT_EQ(batch->sightings.size(), 1U);
    EXPECT_DOUBLE_EQ(batch->sightings[0].range.value(), 3.5);
    EXPECT_FALSE(batch->sightings[0].bearing);
}

TEST(SightingSource, ABadLineCostsItselfOnly) {
    const auto batch = parse_sightings(
        "time,robot,landmark,range,bearing,bearing_sigma\n"
        "x,r1,post1,1,0,\n1,r3,post1,1,0,\n1,r1,post9,1,0,\n1,r1,post1,-1,0,\n1,r1,post1,1,57,\n1,r1,post1,,,\n1,r1,post1,1,0,0\n1,r1,post1,1,0,0.1\n",
        site_with_posts(), -1);
    ASSERT_TRUE(batch);
    EXPECT_EQ(batch->sightings.size(), 1U);
    ASSERT_EQ(batch->problems.size(), 7U);
    const char* said[] = {
        "no time", "no robot 'r3'", "unknown landmark 'post9'", "no range", "is it in degrees?", "neither a range nor a bearing", "no standard deviation"};
    for (std::size_t i = 0; i < 7; ++i) {
        EXPECT_NE(batch->problems[i].find(said[i]), std::string::npos) << batch->problems[i];
        EXPECT_EQ(batch->problems[i].find("line " + std::to_string(i + 2)), 0U) << batch->problems[i];
    }
}

TEST(SightingSource, SaysWhatTheHeaderNeeds) {
    EXPECT_FALSE(parse_sightings("", site_with_posts(), 0));
    EXPECT_FALSE(parse_sightings("time,robot,landmark\n1,r1,post1\n", site_with_posts(), 0));
    EXPECT_FALSE(parse_sightings("range,bearing\n1,1\n", site_with_posts(), 0));
    const auto missing = load_sightings("/nowhere/sightings.csv", site_with_posts(), 0);
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message.find("/nowhere/sightings.csv"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
