#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "roomfix/simulate/write_session.hpp"

namespace roomfix {
namespace {

TEST(CameraRenderer, SameSeedSameBytesOtherSeedOtherNoise) {
    const Scenario scenario = li2014_scenario(3);
    View view = scenario.cameras[2].truth;
    const auto solids = robot_solids(scenario.robots[0].robot.shape, scenario.robots[0].look, {10.5, 10.4, 0.5});
    LumaImage a, b, c, d;
    CameraRenderer(scenario.scene, view, scenario.cameras[2].sensor, 9).render(solids, 1, 4, a);
    const CameraRenderer again(scenario.scene, view, scenario.cameras[2].sensor, 9);
    again.render(solids, 1, 4, b);
    again.render(solids, 1, 5, c);
    again.render({}, 1, 4, d);
    int noise = 0, robot = 0;
    for (int y = 0; y < a.height(); ++y) {
        ASSERT_EQ(std::memcmp(a.row(y), b.row(y), static_cast<std::size_t>(a.width())), 0) << "row " << y;
        for (int x = 0; x < a.width(); ++x) {
            noise += a.row(y)[x] != c.row(y)[x];
            robot += std::abs(a.row(y)[x] - d.row(y)[x]) > 25;
        }
    }
    EXPECT_GT(noise, a.width() * a.height() / 2);
    EXPECT_GT(robot, 300) << "the robot is in the picture";
}

TEST(Scenario, TheLi2014RoomHoldsThePapersPoints) {
    const Scenario scenario = li2014_scenario(1);
    ASSERT_EQ(scenario.cameras.size(), 3U);
    EXPECT_NEAR((scenario.cameras[0].truth.position().head<2>() - Eigen::Vector2d(2.79, 5.70)).norm(), 0, 1e-12);
    EXPECT_EQ(scenario.cameras[2].truth.model.width, 480);
    for (const auto& point : li2014_test_points()) {
        const auto& camera = scenario.cameras[static_cast<std::size_t>(point.camera)];
        const auto pixel = project_map_point(camera.truth, {point.actual.x(), point.actual.y(), 0.2});
        ASSERT_TRUE(pixel);
        EXPECT_TRUE(camera.truth.model.contains(*pixel, 10));
    }
    for (const auto& camera : scenario.site.cameras) EXPECT_TRUE(fixed_view(camera));
}

TEST(Scenario, RobotsDriveWithoutJumps) {
    const Scenario scenario = demo_scenario(1);
    for (const auto& robot : scenario.robots) {
        Pose2 last = robot_pose(robot, 0);
        for (double t = 0.05; t < 120; t += 0.05) {
            const Pose2 pose = robot_pose(robot, t);
            ASSERT_LT(std::hypot(pose.x - last.x, pose.y - last.y), 0.06) << robot.robot.id << " at " << t;
            last = pose;
        }
    }
}

TEST(Scenario, InAHallNobodyRunsIntoAnother) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        const Scenario hall = hall_scenario(seed);
        std::vector<const ScenarioRobot*> all;
        for (const ScenarioRobot& robot : hall.robots) all.push_back(&robot);
        for (const ScenarioRobot& other : hall.others) all.push_back(&other);
        ASSERT_EQ(all.size(), 7U);
        for (double time = 0; time < hall.duration; time += 0.1) {
            for (std::size_t a = 0; a < all.size(); ++a) {
                const Pose2 p = robot_pose(*all[a], time);
                EXPECT_TRUE(p.x > 0.2 && p.y > 0.2 && p.x < 7.8 && p.y < 5.8) << "in the hall";
                for (std::size_t b = a + 1; b < all.size(); ++b) {
                    const Pose2 q = robot_pose(*all[b], time);
                    EXPECT_GT(std::hypot(p.x - q.x, p.y - q.y), 0.4) << all[a]->robot.id << " and " << all[b]->robot.id << " at " << time << " s";
                }
            }
        }
    }
}

TEST(Scenario, AHallIsDrawnAnewForEachSeedAndAsLargeAsAsked) {
    const Scenario one = hall_scenario(1), again = hall_scenario(1), other = hall_scenario(2);
    const auto first = [](const Scenario& hall) { return robot_pose(hall.robots[0], 3); };
    EXPECT_EQ(first(one).x, first(again).x);
    EXPECT_NE(first(one).x, first(other).x);
    EXPECT_NE(half_size(one.robots[0].robot.shape).x(), half_size(other.robots[0].robot.shape).x());
    const Scenario large = hall_scenario(1, {13, 4});
    EXPECT_EQ(large.robots.size(), 13U);
    EXPECT_EQ(large.site.robots.size(), 13U);
    EXPECT_EQ(large.cameras.size(), 4U);
    for (const SiteCamera& camera : large.site.cameras) EXPECT_GE(std::get<KnownFloorPoints>(camera.placement).points.size(), 4U) << camera.id;
    EXPECT_FALSE(large.site.robots[0].odometry) << "the site file says no more of the wheels than that the robot drives";
    EXPECT_TRUE(large.robots[0].robot.odometry);
}

TEST(WriteSession, WritesAllPartsAndNeverOverASession) {
    const auto folder = std::filesystem::temp_directory_path() / "roomfix_write_session_test";
    std::filesystem::remove_all(folder);
    Scenario scenario = li2014_scenario(1);
    scenario.cameras.resize(1);
    scenario.site.cameras.resize(1);
    ASSERT_TRUE(write_session(scenario, folder, {.duration = 0.2, .background_frames = 1}));
    EXPECT_TRUE(std::filesystem::exists(folder / "frames/hall1/000100000000.jpg"));
    EXPECT_TRUE(std::filesystem::exists(folder / "truth.csv"));
    const auto again = write_session(scenario, folder, {.duration = 0.2});
    ASSERT_FALSE(again);
    EXPECT_NE(again.error().message.find("session already"), std::string::npos);
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace roomfix
