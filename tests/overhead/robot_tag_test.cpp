#include "roomfix/overhead/robot_tag.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/simulate/tag_scene.hpp"

namespace roomfix {
namespace {

TEST(RobotTag, GivesThePoseWithATrueCovariance) {
    View view{make_camera_model(640, 480, 520, 520, 320, 240), {looking_at({0, 0, 2.4}, {3, 0, 0.3}), Matrix6d::Zero()}};
    SiteRobot robot{"r1", Box{0.6, 0.5, 0.4}};
    robot.tag = Tag{3, 0.16};
    robot.robot_from_tag.linear() << 0, 1, 0, -1, 0, 0, 0, 0, 1;  // its upper edge forward
    robot.robot_from_tag.translation() = Eigen::Vector3d(-0.05, 0.02, 0.4);
    Random random(2);
    double sum = 0;
    constexpr int runs = 300;  // 3 +- 0.55 is a false alarm in 1e-4
    for (int i = 0; i < runs; ++i) {
        const Pose2 truth{random.uniform(2, 4), random.uniform(-1, 1), random.uniform(-3, 3)};
        std::array<Eigen::Vector2d, 4> corners;
        const auto own = own_points(*robot.tag);
        for (std::size_t k = 0; k < 4; ++k) {
            corners[k] =
                *project_map_point(view, map_from_robot(truth) * robot.robot_from_tag * own[k]) + Eigen::Vector2d(random.normal(0.1), random.normal(0.1));
        }
        const auto fit = fit_robot_tag(view, robot, corners, 0.1);
        ASSERT_TRUE(fit);
        const Eigen::Vector3d error(fit->pose.x - truth.x, fit->pose.y - truth.y, wrap_angle(fit->pose.yaw - truth.yaw));
        sum += error.dot(fit->covariance.inverse() * error);
    }
    EXPECT_NEAR(sum / runs, 3, 0.55);
    const std::array<Eigen::Vector2d, 4> upside_down = {{{300, 200}, {330, 200}, {330, 230}, {300, 230}}};
    EXPECT_FALSE(fit_robot_tag(view, robot, upside_down, 0.1)) << "a tag seen from behind is not this robot's";
}

TEST(RobotTag, IsFoundInAPicture) {
    const View view{make_camera_model(640, 480, 520, 520, 320, 240), {looking_at({0, 0, 2.4}, {3, 0, 0.3}), Matrix6d::Zero()}};
    SiteRobot robot{"r1", Box{0.6, 0.5, 0.4}};
    robot.tag = Tag{3, 0.24};
    robot.robot_from_tag.linear() << 0, 1, 0, -1, 0, 0, 0, 0, 1;
    robot.robot_from_tag.translation() = Eigen::Vector3d(0, 0, 0.4);
    const Pose2 truth{2.6, 0.3, 2.0};
    LumaImage frame(640, 480);
    for (int y = 0; y < 480; ++y) std::memset(frame.row(y), 110, 640);
    paint_tag(view, map_from_robot(truth) * robot.robot_from_tag, *robot.tag, 1.5, 1, frame);
    TagDetector detector;
    const auto found = find_tagged_robots(view, {SiteRobot{"other", Box{1, 1, 1}}, robot}, detector, frame);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].robot, 1);
    EXPECT_LT(std::hypot(found[0].fit.pose.x - truth.x, found[0].fit.pose.y - truth.y), 0.01);
    EXPECT_LT(std::abs(wrap_angle(found[0].fit.pose.yaw - truth.yaw)), radians(2)) << "front and back are told apart";
}

}  // namespace
}  // namespace roomfix
