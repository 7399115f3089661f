#include "roomfix/overhead/silhouette.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "roomfix/base/random.hpp"
#include "standing_camera.hpp"

namespace roomfix {
namespace {

constexpr Box oblong_box{0.8, 0.5, 0.4};

/// Does the ray of a pixel meet the box? By its three pairs of faces, in the robot's frame.
bool shows_box(const View& view, const Eigen::Vector2d& pixel, const Box& box, const Pose2& pose) {
    const Eigen::Vector3d ray = view.map_from_camera.pose.linear() * unproject(view.model, pixel)->homogeneous();
    const Eigen::Rotation2Dd robot_from_map(-pose.yaw);
    const Eigen::Vector2d direction = robot_from_map * ray.head<2>();
    const Eigen::Vector2d start = robot_from_map * (view.position().head<2>() - Eigen::Vector2d(pose.x, pose.y));
    double enters = 0, leaves = 1e9;
    const auto between = [&](double from, double along, double low, double high) {
        const double a = (low - from) / along, b = (high - from) / along;
        enters = std::max(enters, std::min(a, b));
        leaves = std::min(leaves, std::max(a, b));
    };
    between(start.x(), direction.x(), -box.length / 2, box.length / 2);
    between(start.y(), direction.y(), -box.width / 2, box.width / 2);
    between(view.position().z(), ray.z(), 0, box.height);
    return enters < leaves;
}

TEST(Silhouette, IsWhereTheRaysMeetTheBody) {
    const View view = standing_camera({-1, -1, 3}, {2, 1, 0});
    const ShapePoints shape = shape_points(oblong_box, 0.005);
    Random random(31);
    for (int i = 0; i < 20; ++i) {
        const Pose2 pose{random.uniform(1, 3), random.uniform(0, 2), random.uniform(-3, 3)};
        const Silhouette silhouette = project_silhouette(view, shape, pose);
        ASSERT_TRUE(silhouette.valid());
        int inside = 0;
        for (int k = 0; k < 4000; ++k) {
            const Eigen::Vector2d pixel(random.uniform(0, 639), random.uniform(0, 479));
            const bool shown = shows_box(view, pixel, oblong_box, pose);
            inside += shown;
            EXPECT_TRUE(inside_polygon(silhouette.polygon(), pixel, 1e-6) || !shown) << pixel.transpose();
            EXPECT_FALSE(inside_polygon(silhouette.polygon(), pixel, -1e-6) && !shown) << pixel.transpose();
        }
        EXPECT_GT(inside, 10);
        for (int corner = 0; corner < silhouette.count; ++corner) {
            const auto c = static_cast<std::size_t>(corner);
            const auto pixel = project_map_point(view, body_point_map(shape, silhouette.indices[c], pose));
            EXPECT_LT((*pixel - silhouette.corners[c]).norm(), 1e-9) << "the corners say which points of the body they are";
        }
    }
}

TEST(Silhouette, ABodyBehindTheCameraHasNone) {
    const View view = standing_camera({0, 0, 2}, {4, 0, 0});
    EXPECT_FALSE(project_silhouette(view, shape_points(oblong_box, 0.005), {-3, 0, 0}).valid());
    EXPECT_FALSE(project_silhouette(view, shape_points(Cylinder{0.5, 2.5}, 0.005), {-0.1, 0, 0}).valid()) << "nor one that is partly behind it";
}

TEST(Silhouette, TurnsThatLookTheSameAreNoDifference) {
    const ShapePoints oblong = shape_points(oblong_box, 0.005), square = shape_points(Box{0.5, 0.502, 0.4}, 0.005),
                      round = shape_points(Cylinder{0.5, 1}, 0.005);
    constexpr double pi = std::numbers::pi;
    EXPECT_NEAR(pose_difference({0, 0, 0.1}, {0, 0, 0.1 + pi}, oblong).z(), 0, 1e-12);
    EXPECT_NEAR(std::abs(pose_difference({0, 0, 0.1}, {0, 0, 0.1 + pi / 2}, oblong).z()), pi / 2, 1e-12);
    EXPECT_NEAR(pose_difference({0, 0, 0.1}, {0, 0, 0.12 - pi / 2}, square).z(), 0.02, 1e-12);
    EXPECT_EQ(pose_difference({0, 0, 0.1}, {1, 2, 2.5}, round), Eigen::Vector3d(1, 2, 0));
}

/// 20 x 10 px, turned by 30 degrees about (60, 40).
std::vector<Eigen::Vector2d> turned_rectangle() {
    std::vector<Eigen::Vector2d> polygon;
    for (const auto& [x, y] : {std::pair{-10.0, -5.0}, {10.0, -5.0}, {10.0, 5.0}, {-10.0, 5.0}}) {
        polygon.push_back(Eigen::Vector2d(60, 40) + Eigen::Rotation2Dd(std::numbers::pi / 6) * Eigen::Vector2d(x, y));
    }
    return polygon;
}

TEST(Silhouette, AreaAndMiddleOfAPolygon) {
    EXPECT_NEAR(std::abs(polygon_area(turned_rectangle())), 200, 1e-9);
    EXPECT_LT((polygon_centroid(turned_rectangle()) - Eigen::Vector2d(60, 40)).norm(), 1e-9);
    const PixelBox box = box_around(turned_rectangle());
    EXPECT_NEAR(box.high.x() - box.low.x(), 20 * std::cos(std::numbers::pi / 6) + 10 * 0.5, 1e-9);
}

TEST(Silhouette, CountsWhatLiesInIt) {
    BitMask foreground(128, 96), shadow(128, 96), taken(128, 96);
    for (int y = 0; y < 96; ++y) foreground.set_run(y, 0, 60);
    for (int y = 0; y < 40; ++y) shadow.set_run(y, 0, 60);
    const auto polygon = turned_rectangle();
    const RegionCount all = count_region(foreground, shadow, nullptr, polygon, 1);
    EXPECT_NEAR(all.area, 200, 10);
    EXPECT_NEAR(all.foreground, 100, 8) << "the left half of it";
    EXPECT_GT(all.shadow, 0);
    EXPECT_LT(all.shadow, all.foreground);
    EXPECT_EQ(all.taken, 0);
    EXPECT_NEAR(count_region(foreground, shadow, nullptr, polygon, 2).area, all.area, 12) << "every other row counts twice";
    for (int y = 0; y < 96; ++y) taken.set_run(y, 60, 128);
    const RegionCount rest = count_region(foreground, shadow, &taken, polygon, 1);
    EXPECT_EQ(rest.foreground, all.foreground);
    EXPECT_EQ(rest.area - rest.taken, rest.foreground) << "what others explain says nothing";
}

TEST(Silhouette, WhatIsFilledIsClearedAgain) {
    BitMask mask(128, 96);
    const auto polygon = turned_rectangle();
    fill_region(mask, polygon);
    EXPECT_NEAR(static_cast<double>(mask.count()), 200, 10);
    EXPECT_TRUE(mask.at(60, 40));
    clear_region(mask, polygon);
    EXPECT_EQ(mask.count(), 0);
}

TEST(Silhouette, PolygonsThatReachOutOfThePictureAreCutOff) {
    BitMask mask(64, 48);
    const std::vector<Eigen::Vector2d> around = {{-100, -80}, {200, -90}, {180, 150}, {-120, 140}};
    fill_region(mask, around);
    EXPECT_EQ(mask.count(), 64 * 48);
    const std::vector<Eigen::Vector2d> beside = {{70, 10}, {90, 10}, {80, 30}};
    EXPECT_EQ(count_region(mask, mask, nullptr, beside, 1).area, 0);
}

}  // namespace
}  // namespace roomfix
