#include "roomfix/connect/ros_fix.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace roomfix {
namespace {

Fix fix_at(double x, double y, double yaw) {
    Fix fix;
    fix.status = FixStatus::ok;
    fix.pose = {x, y, yaw};
    fix.covariance << 0.04, 0.01, 0.002, 0.01, 0.05, 0.003, 0.002, 0.003, 0.06;
    return fix;
}

TEST(RosFix, PutsThePlaneIntoSixAxes) {
    const ros::Covariance six = ros::planar_covariance(fix_at(0, 0, 0).covariance, true);
    EXPECT_EQ(six[0], 0.04);
    EXPECT_EQ(six[1], 0.01);
    EXPECT_EQ(six[5], 0.002);
    EXPECT_EQ(six[7], 0.05);
    EXPECT_EQ(six[11], 0.003);
    EXPECT_EQ(six[35], 0.06);
    const Eigen::Map<const Eigen::Matrix<double, 6, 6>> matrix(six.data());
    EXPECT_TRUE(matrix.isApprox(matrix.transpose()));
    EXPECT_GT(matrix.eigenvalues().real().minCoeff(), 0);
}

TEST(RosFix, AYawThatNobodyKnowsIsAnywhere) {
    Fix fix = fix_at(1, 2, 3);
    fix.yaw_known = false;
    fix.covariance.row(2).setConstant(std::numeric_limits<double>::quiet_NaN());  // says nothing
    ASSERT_TRUE(ros::has_pose(fix));
    const ros::PoseWithCovarianceStamped message = ros::pose_message(fix);
    EXPECT_NEAR(message.covariance[35], std::numbers::pi * std::numbers::pi / 3, 1e-12);
    EXPECT_EQ(message.covariance[5], 0);
    EXPECT_EQ(message.covariance[30], 0);
    EXPECT_EQ(message.pose.orientation.w(), 1);
}

TEST(RosFix, WhatIsNoPoseIsTold) {
    EXPECT_TRUE(ros::has_pose(fix_at(1, 2, 3)));
    Fix none = fix_at(1, 2, 3);
    none.status = FixStatus::none;
    EXPECT_FALSE(ros::has_pose(none));
    Fix perfect = fix_at(1, 2, 3);
    perfect.covariance.setZero();
    EXPECT_FALSE(ros::has_pose(perfect));
    Fix crooked = fix_at(1, 2, 3);
    crooked.covariance(0, 1) = -0.01;
    EXPECT_FALSE(ros::has_pose(crooked));
    EXPECT_FALSE(ros::has_pose(fix_at(std::numeric_limits<double>::infinity(), 0, 0)));
}

TEST(RosFix, MapFromOdomTurnsTheWayOfTheWheelsIntoTheMap) {
    const Pose2 odom_from_base{2, 1, 0.5}, map_from_base{10, 20, 0.5 + std::numbers::pi / 2};
    const Pose2 odom = ros::map_from_odom(map_from_base, odom_from_base);
    EXPECT_NEAR(odom.yaw, std::numbers::pi / 2, 1e-12);
    EXPECT_NEAR(odom.x, 10 + 1, 1e-12);  // odom's x is the map's y, its y the map's -x
    EXPECT_NEAR(odom.y, 20 - 2, 1e-12);
}

TEST(RosMessage, StandsInCdrByteForByte) {
    ros::DiagnosticArray message{{1'500'000'002, "m"}, {{ros::Level::error, "n", "", "h", {{"k", "v"}}}}};
    const Bytes expected = {0, 1, 0, 0,                         // CDR, little endian
                            1, 0, 0, 0, 2,   0x65, 0xcd, 0x1d,  // 1 s, 500000002 ns
                            2, 0, 0, 0, 'm', 0,    0,    0,     // length with the zero, and two bytes up to a multiple of four
                            1, 0, 0, 0,                         // one status
                            2, 0, 0, 0,                         // its level, and three bytes
                            2, 0, 0, 0, 'n', 0,    0,    0,     //
                            1, 0, 0, 0, 0,   0,    0,    0,     // an empty text
                            2, 0, 0, 0, 'h', 0,    0,    0,     //
                            1, 0, 0, 0,                         // one pair
                            2, 0, 0, 0, 'k', 0,    0,    0,    2, 0, 0, 0, 'v', 0};
    EXPECT_EQ(ros::encode(message), expected);
}

TEST(RosMessage, ROSCountsSecondsIn31Bits) {
    EXPECT_FALSE(ros::can_state(-1));
    EXPECT_TRUE(ros::can_state(0));
    EXPECT_TRUE(ros::can_state(2'147'483'647'999'999'999));
    EXPECT_FALSE(ros::can_state(2'147'483'648'000'000'000));
}

}  // namespace
}  // namespace roomfix
