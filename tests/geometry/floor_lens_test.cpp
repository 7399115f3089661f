#include "roomfix/geometry/floor_lens.hpp"

#include <gtest/gtest.h>

#include <random>

#include "roomfix/geometry/view.hpp"

namespace roomfix {
namespace {

/// Corners of a board on the floor, seen by a camera of that focal length, read with 0.1 px of noise.
std::vector<FloorPoint> board_points(double focal, int columns, int rows, unsigned seed) {
    View view;
    view.model = make_camera_model(1280, 720, focal, focal, 640, 360);
    view.map_from_camera.pose = Eigen::Isometry3d::Identity();
    // Looks along x and down by 30 degrees from 2.2 m.
    const Eigen::Vector3d forward = Eigen::Vector3d(0.866, 0, -0.5).normalized();
    const Eigen::Vector3d right(0, -1, 0);
    view.map_from_camera.pose.linear() << right, forward.cross(right), forward;
    view.map_from_camera.pose.translation() = Eigen::Vector3d(0, 0, 2.2);
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 0.1);
    std::vector<FloorPoint> points;
    for (int i = 0; i < columns; ++i) {
        for (int j = 0; j < rows; ++j) {
            const Eigen::Vector2d map(3.0 + 0.14 * i, -0.3 + 0.14 * j);
            const auto pixel = project_map_point(view, {map.x(), map.y(), 0});
            if (pixel) points.push_back({*pixel + Eigen::Vector2d(noise(random), noise(random)), map});
        }
    }
    return points;
}

TEST(FloorLens, ExactPointsShowThatTheFocalLengthIsNotAsStated) {
    const CameraModel stated = make_camera_model(1280, 720, 1100, 1100, 640, 360);
    const auto points = board_points(1190, 7, 5, 3);
    const auto pose = camera_pose_from_floor_points(stated, points, 0.5);
    ASSERT_TRUE(pose);
    const auto lens = lens_from_floor_points(stated, *pose, points);
    ASSERT_TRUE(lens);
    EXPECT_NEAR(lens->model.fx, 1190, 3 * std::sqrt(lens->intrinsics.covariance(0, 0)));
    EXPECT_NEAR(lens->map_from_camera.pose.translation().z(), 2.2, 0.1);
    EXPECT_GT(lens->intrinsics.covariance(0, 0), 1) << "a small board does not fix it exactly";
}

TEST(FloorLens, ALensAsStatedStays) {
    const CameraModel stated = make_camera_model(1280, 720, 1100, 1100, 640, 360);
    int changed = 0;
    for (unsigned seed = 0; seed < 20; ++seed) {
        const auto points = board_points(1100, 7, 5, seed);
        const auto pose = camera_pose_from_floor_points(stated, points, 0.5);
        ASSERT_TRUE(pose);
        changed += lens_from_floor_points(stated, *pose, points).has_value();
    }
    EXPECT_LE(changed, 1);
}

TEST(FloorLens, AFewClicksSayNothingAboutTheLens) {
    const CameraModel stated = make_camera_model(1280, 720, 1100, 1100, 640, 360);
    const auto points = board_points(1190, 3, 2, 3);
    const auto pose = camera_pose_from_floor_points(stated, points, 0.5);
    ASSERT_TRUE(pose);
    EXPECT_FALSE(lens_from_floor_points(stated, *pose, points));
}

}  // namespace
}  // namespace roomfix
