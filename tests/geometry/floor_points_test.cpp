#include "roomfix/geometry/floor_points.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/geometry/view.hpp"

namespace roomfix {
namespace {

View camera() { return {make_camera_model(640, 480, 520, 520, 318, 241, {0.05, -0.2, 0.001, 0, 0}), {looking_at({1, -1, 2.4}, {2, 3, 0}), Matrix6d::Zero()}}; }

std::vector<FloorPoint> points_of(const View& view, int across, double sigma, Random& random) {
    std::vector<FloorPoint> points;
    for (int i = 0; i < across; ++i) {
        for (int j = 0; j < across; ++j) {
            const Eigen::Vector2d map(0.8 + 2.0 * i / (across - 1), 2 + 2.5 * j / (across - 1));
            const auto pixel = project_map_point(view, {map.x(), map.y(), 0});
            points.push_back({*pixel + Eigen::Vector2d(random.normal(sigma), random.normal(sigma)), map});
        }
    }
    return points;
}

/// The error vector of a pose in the convention of UncertainPose3.
Vector6d error_of(const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& truth) {
    const Eigen::AngleAxisd turn(truth.linear() * estimate.linear().transpose());
    Vector6d e;
    e << truth.translation() - estimate.translation(), turn.angle() * turn.axis();
    return e;
}

TEST(FloorPoints, FourExactPointsGiveThePose) {
    const View view = camera();
    Random random(1);
    const auto solved = camera_pose_from_floor_points(view.model, points_of(view, 2, 0, random), 0.5);
    ASSERT_TRUE(solved) << solved.error().message;
    EXPECT_LT(error_of(solved->map_from_camera.pose, view.map_from_camera.pose).norm(), 1e-7);
}

TEST(FloorPoints, TheCovarianceIsTrue) {
    // Mean NEES over 300 runs with 6 unknowns: outside 6 +- 3 * sqrt(12 / 300) once in 370 times if the covariance is true.
    const View view = camera();
    Random random(7);
    double sum = 0;
    constexpr int runs = 300;
    for (int i = 0; i < runs; ++i) {
        const auto solved = camera_pose_from_floor_points(view.model, points_of(view, 4, 0.5, random), 0.5);
        ASSERT_TRUE(solved);
        const Vector6d e = error_of(solved->map_from_camera.pose, view.map_from_camera.pose);
        sum += e.dot(solved->map_from_camera.covariance.inverse() * e);
    }
    EXPECT_NEAR(sum / runs, 6, 0.6);
}

TEST(FloorPoints, RefusesWhatDoesNotFixThePose) {
    const View view = camera();
    Random random(2);
    auto points = points_of(view, 2, 0, random);
    auto three = points;
    three.pop_back();
    const auto too_few = camera_pose_from_floor_points(view.model, three, 0.5);
    ASSERT_FALSE(too_few);
    EXPECT_NE(too_few.error().message.find("four or more"), std::string::npos);

    std::vector<FloorPoint> line;
    for (int i = 0; i < 6; ++i) {
        const Eigen::Vector2d map(1 + 0.2 * i, 2 + 0.4 * i);
        line.push_back({*project_map_point(view, {map.x(), map.y(), 0}), map});
    }
    const auto collinear = camera_pose_from_floor_points(view.model, line, 0.5);
    ASSERT_FALSE(collinear);
    EXPECT_NE(collinear.error().message.find("one line"), std::string::npos);

    for (auto& p : points) p.map.x() = -p.map.x();  // a mirrored map
    EXPECT_FALSE(camera_pose_from_floor_points(view.model, points, 0.5));
}

TEST(FloorPoints, DisagreeingPointsGrowTheCovariance) {
    const View view = camera();
    Random random(3);
    auto points = points_of(view, 4, 0.3, random);
    const auto good = camera_pose_from_floor_points(view.model, points, 0.3);
    points[5].pixel += Eigen::Vector2d(25, -10);
    const auto bad = camera_pose_from_floor_points(view.model, points, 0.3);
    ASSERT_TRUE(good && bad);
    EXPECT_GT(bad->map_from_camera.covariance(0, 0), 20 * good->map_from_camera.covariance(0, 0));
    EXPECT_EQ(bad->worst, 5);
}

TEST(View, PixelToPlaneInvertsProjectionAndKnowsItsDerivatives) {
    View view = camera();
    for (const double height : {0.0, 0.45}) {
        const Eigen::Vector3d p(1.7, 3.1, height);
        const auto pixel = project_map_point(view, p);
        ASSERT_TRUE(pixel);
        const auto plane = pixel_to_plane(view, *pixel, height);
        ASSERT_TRUE(plane);
        EXPECT_LT((plane->point - p.head<2>()).norm(), 1e-10);
        for (int k = 0; k < 6; ++k) {
            View moved = view;
            moved.map_from_camera.pose = perturbed(view.map_from_camera.pose, 1e-6 * Vector6d::Unit(k));
            const auto shifted = pixel_to_plane(moved, *pixel, height);
            EXPECT_LT((plane->by_pose.col(k) - (shifted->point - plane->point) / 1e-6).norm(), 1e-4) << k;
        }
    }
    EXPECT_FALSE(pixel_to_plane(view, {320, -3000}, 0)) << "above the horizon";
}

}  // namespace
}  // namespace roomfix
