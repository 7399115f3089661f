#include "roomfix/connect/odometry_source.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

Site one_robot() {
    Site site;
    site.robots.resize(1);
    site.robots[0].id = "r1";
    return site;
}

TEST(OdometrySource, ReadsColumnsInAnyOrder) {
    const auto batch = parse_odometry("yaw,extra,time,x,y\r\n0.5,7,1.000000001,2,3\n", one_robot(), 0);
    ASSERT_TRUE(batch);
    ASSERT_EQ(batch->poses.size(), 1U);
    EXPECT_EQ(batch->poses[0].time, 1000000001);
    EXPECT_EQ(batch->poses[0].pose.x, 2);
    EXPECT_EQ(batch->poses[0].pose.yaw, 0.5);
}

TEST(OdometrySource, ABadLineCostsItselfOnly) {
    const auto batch = parse_odometry("time,robot,x,y,yaw\n1,r1,0,0,0\n2,r2,0,0,0\n3,r1,nan,0,0\n4,r1,0\n5,r1,1,0,0\n", one_robot(), 0);
    ASSERT_TRUE(batch);
    EXPECT_EQ(batch->poses.size(), 2U);
    ASSERT_EQ(batch->problems.size(), 3U);
    EXPECT_EQ(batch->problems[0], "line 3: the site has no robot 'r2'");
    EXPECT_EQ(batch->problems[1], "line 4: 'nan' is no number");
}

TEST(OdometrySource, AHeaderThatDoesNotFitIsAnError) {
    EXPECT_FALSE(parse_odometry("t,x,y\n", one_robot(), 0));
    EXPECT_FALSE(parse_odometry("", one_robot(), 0));
    const auto missing = load_odometry("/nowhere/odometry.csv", one_robot(), 0);
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message.find("/nowhere/odometry.csv: cannot be read"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
