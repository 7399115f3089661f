#include "roomfix/connect/ros_odometry.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "roomfix/connect/ros_fix.hpp"
#include "roomfix/connect/ros_graph.hpp"

namespace roomfix {
namespace {

ros::Odometry odometry_at(double time, const Pose2& pose) {
    ros::Odometry message{{from_seconds(time), "odom"}, "base_link", ros::pose_of(pose)};
    for (std::size_t i = 0; i < 6; ++i) message.pose_covariance[7 * i] = message.twist_covariance[7 * i] = 0.01 + static_cast<double>(i);
    message.linear = {0.5, 0, 0};
    message.angular = {0, 0, -0.2};
    return message;
}

TEST(RosOdometry, IsReadAsItWasWritten) {
    const ros::Odometry sent = odometry_at(1000.25, {1, -2, 2.5});
    const auto got = ros::decode_odometry(ros::encode(sent));
    ASSERT_TRUE(got);
    EXPECT_EQ(got->header.stamp, sent.header.stamp);
    EXPECT_EQ(got->header.frame_id, "odom");
    EXPECT_EQ(got->child_frame_id, "base_link");
    EXPECT_EQ(got->pose.position, sent.pose.position);
    EXPECT_EQ(got->pose.orientation.coeffs(), sent.pose.orientation.coeffs());
    EXPECT_EQ(got->pose_covariance, sent.pose_covariance);
    EXPECT_EQ(got->linear, sent.linear);
    EXPECT_EQ(got->angular, sent.angular);
    EXPECT_EQ(got->twist_covariance, sent.twist_covariance);
    const auto pose = pose_of_wheels(*got);
    ASSERT_TRUE(pose) << pose.error().message;
    EXPECT_NEAR(pose->x, 1, 1e-12);
    EXPECT_NEAR(pose->yaw, 2.5, 1e-12);
}

/// From a machine that counts the other way: each number's bytes turned around where it stands.
TEST(RosOdometry, EitherByteOrderIsRead) {
    ros::Odometry sent = odometry_at(1000.25, {1, -2, 2.5});
    sent.header.frame_id = "odometr";  // eight bytes with its zero, as is the next one: all numbers stand at even places
    sent.child_frame_id = "base_lk";
    Bytes message = ros::encode(sent);
    message[1] = 0;
    const auto turn = [&](std::size_t at, std::size_t size) {
        std::reverse(message.begin() + static_cast<long>(at), message.begin() + static_cast<long>(at + size));
    };
    for (const std::size_t at : {4U, 8U, 12U, 24U}) turn(at, 4);  // seconds, nanoseconds, lengths of both texts
    for (std::size_t at = 36; at < message.size(); at += 8) turn(at, 8);
    const auto got = ros::decode_odometry(message);
    ASSERT_TRUE(got);
    EXPECT_EQ(got->header.stamp, sent.header.stamp);
    EXPECT_EQ(got->child_frame_id, "base_lk");
    EXPECT_EQ(got->pose.position, sent.pose.position);
    EXPECT_EQ(got->twist_covariance, sent.twist_covariance);
}

TEST(RosOdometry, APartOfAMessageIsNone) {
    const Bytes whole = ros::encode(odometry_at(1000.25, {1, -2, 2.5}));
    for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(ros::decode_odometry(std::span(whole).first(size))) << size;
    Bytes other = whole;
    other[1] = 3;  // a list of parameters
    EXPECT_FALSE(ros::decode_odometry(other));
    other = whole;
    other[8] = other[9] = other[10] = other[11] = 0xff;  // more nanoseconds than a second has
    EXPECT_FALSE(ros::decode_odometry(other));
    other = whole;
    other[7] = 0xff;  // before 1970
    EXPECT_FALSE(ros::decode_odometry(other));
    other = whole;
    other[12] = other[13] = other[14] = other[15] = 0xff;  // a text of four gigabytes
    EXPECT_FALSE(ros::decode_odometry(other));
}

std::string refusal_of(const ros::Odometry& message) {
    const auto pose = pose_of_wheels(message);
    return pose ? "" : pose.error().message;
}

TEST(RosOdometry, WhatIsNoPoseOfWheelsIsRefusedWithItsReason) {
    ros::Odometry message = odometry_at(1, {1, 2, 0});
    EXPECT_EQ(refusal_of(message), "");
    message.header.frame_id = "map";
    EXPECT_NE(refusal_of(message).find("localiser"), std::string::npos);
    message = odometry_at(1, {0, 0, 0});
    EXPECT_EQ(refusal_of(message), "");  // wheels begin somewhere
    message.pose_covariance[0] = 1e6;
    EXPECT_NE(refusal_of(message).find("twist, but no pose"), std::string::npos);
    message.pose_covariance[0] = -1;
    message.pose.orientation.coeffs().setZero();
    EXPECT_NE(refusal_of(message).find("twist, but no pose"), std::string::npos);
    message = odometry_at(1, {1, 2, 0});
    message.pose.orientation.coeffs().setZero();
    EXPECT_NE(refusal_of(message).find("quaternion"), std::string::npos);
    message = odometry_at(1, {std::numeric_limits<double>::quiet_NaN(), 2, 0});
    EXPECT_NE(refusal_of(message).find("not finite"), std::string::npos);
    message = odometry_at(1, {1e300, 2, 0});
    EXPECT_NE(refusal_of(message).find("farther"), std::string::npos);
}

TEST(RosOdometry, TheSendersClockIsFollowedAndWhatWasNotUsedIsTold) {
    RosOdometry wheels(3);
    OdometryBatch batch;
    for (int i = 0; i < 50; ++i) {
        batch = wheels.read(ros::encode(odometry_at(500 + 0.05 * i, {0.1 * i, 0, 0})), from_seconds(1500.003 + 0.05 * i), 0.05 * i);
        ASSERT_EQ(batch.poses.size(), 1U);
        EXPECT_EQ(batch.poses[0].robot, 3);
    }
    EXPECT_NEAR(to_seconds(batch.poses[0].time), 1502.453, 1e-3);
    EXPECT_NE(wheels.told().find("1000.003 s behind ours"), std::string::npos) << wheels.told();
    ros::Odometry twist = odometry_at(503, {});
    twist.pose_covariance[0] = 1e9;
    batch = wheels.read(ros::encode(twist), from_seconds(1503), 3);
    EXPECT_TRUE(batch.poses.empty());
    EXPECT_EQ(batch.problems.size(), 1U);
    EXPECT_TRUE(wheels.read(ros::encode(twist), from_seconds(1504), 4).problems.empty());  // it was said
    EXPECT_NE(wheels.told().find("2 messages were not used"), std::string::npos) << wheels.told();
    batch = wheels.read(ros::encode(odometry_at(0, {1, 2, 0})), from_seconds(1505), 5);
    ASSERT_EQ(batch.poses.size(), 1U);
    EXPECT_EQ(batch.poses[0].time, from_seconds(1505));
    EXPECT_NE(wheels.told().find("no time"), std::string::npos) << wheels.told();
}

TEST(RosFix, OdometryHasTheTwistInTheRobotsAxes) {
    Fix fix;
    fix.time = from_seconds(5);
    fix.status = FixStatus::ok;
    fix.pose = {1, 2, std::numbers::pi / 2};
    fix.covariance = Eigen::Vector3d(0.01, 0.01, 0.0025).asDiagonal();
    EXPECT_FALSE(ros::has_twist(fix));
    fix.velocity = Eigen::Vector3d(-0.1, 0.8, 0.3);  // ahead is the map's y, to the left its -x
    fix.velocity_covariance = Eigen::Vector3d(0.02, 0.05, 0.07).asDiagonal();
    ASSERT_TRUE(ros::has_twist(fix));
    const ros::Odometry message = ros::odometry_message(fix, "r1/base_link");
    EXPECT_EQ(message.header.frame_id, "map");
    EXPECT_EQ(message.child_frame_id, "r1/base_link");
    EXPECT_LT((message.linear - Eigen::Vector3d(0.8, 0.1, 0)).norm(), 1e-12);
    EXPECT_EQ(message.angular.z(), 0.3);
    EXPECT_NEAR(message.twist_covariance[0], 0.05 + 0.0025 * 0.01, 1e-12);
    EXPECT_NEAR(message.twist_covariance[7], 0.02 + 0.0025 * 0.64, 1e-12);  // what it may slip by where its front is not quite there
    EXPECT_NEAR(message.twist_covariance[35], 0.07, 1e-12);
    const Eigen::Map<const Eigen::Matrix<double, 6, 6>> matrix(message.twist_covariance.data());
    EXPECT_GT(matrix.eigenvalues().real().minCoeff(), 0);
    fix.velocity_covariance(0, 0) = 0;
    EXPECT_FALSE(ros::has_twist(fix));
    fix.velocity_covariance(0, 0) = 0.02;
    fix.yaw_known = false;  // nobody knows which way is ahead
    EXPECT_FALSE(ros::has_twist(fix));
}

TEST(RosGraph, TheLayoutOfOthersIsRecognised) {
    ros::ParticipantEntitiesInfo info;
    info.participant.fill(7);
    info.node_name = "roomfix";
    for (std::uint8_t i = 0; i < 5; ++i) {
        info.writers.emplace_back().fill(i);
        for (const auto layout : {ros::GraphLayout::numbers_of_16_bytes, ros::GraphLayout::numbers_of_24_bytes}) {
            const Bytes message = ros::encode(info, layout);
            EXPECT_EQ(ros::layout_of_graph(message), layout) << static_cast<int>(i);
            EXPECT_FALSE(ros::layout_of_graph(std::span(message).first(message.size() - 5)));
        }
    }
    EXPECT_FALSE(ros::layout_of_graph({}));
}

}  // namespace
}  // namespace roomfix
