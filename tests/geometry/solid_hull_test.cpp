#include "roomfix/geometry/solid_hull.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <numbers>

#include "roomfix/base/random.hpp"
#include "roomfix/geometry/solid_line.hpp"
#include "roomfix/geometry/triangle_mesh.hpp"

namespace roomfix {
namespace {

TEST(TriangleMesh, SolidsAreClosedAndFaceOutwards) {
    EXPECT_NEAR(enclosed_volume(box_mesh({2, 3, 4})), 24, 1e-12);
    EXPECT_NEAR(enclosed_volume(cylinder_mesh(0.5, 2)), std::numbers::pi / 2, 0.02);
    EXPECT_NEAR(enclosed_volume(ball_mesh(2)), 32 * std::numbers::pi / 3, 1e-9);
    EXPECT_EQ(icosphere(0).corners.size(), 12U);
    EXPECT_EQ(icosphere(3).corners.size(), 642U);
    TriangleMesh mirrored;
    append(mirrored, box_mesh({2, 3, 4}), Eigen::Affine3d(Eigen::Scaling(-1.0, 1.0, 0.5)));
    EXPECT_NEAR(enclosed_volume(mirrored), 12, 1e-12) << "a mirrored mesh still faces outwards";
}

TEST(HullVolume, IsThatOfKnownSolids) {
    EXPECT_NEAR(hull_volume(box_mesh({2, 3, 4}).corners), 24, 1e-9);
    EXPECT_NEAR(hull_volume(icosphere(2).corners), enclosed_volume(icosphere(2)), 1e-9);
    EXPECT_NEAR(hull_volume(std::vector<Eigen::Vector3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), 1.0 / 6, 1e-12);
}

TEST(HullVolume, OfFlatPointsIsNothing) {
    EXPECT_EQ(hull_volume({}), 0);
    EXPECT_EQ(hull_volume(std::vector<Eigen::Vector3d>(10, {1, 2, 3})), 0);
    EXPECT_EQ(hull_volume(std::vector<Eigen::Vector3d>{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {0.3, 0.7, 1}}), 0);
    EXPECT_EQ(hull_volume(std::vector<Eigen::Vector3d>{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}), 0);
}

TEST(HullVolume, IsThatOfTheBoxHoweverManyPointsLieInItsFaces) {
    EXPECT_TRUE(rc::check([] {
        Random random(*rc::gen::arbitrary<std::uint32_t>());
        const Eigen::Vector3d size(random.uniform(0.01, 2), random.uniform(0.01, 2), random.uniform(0.01, 2));
        std::vector<Eigen::Vector3d> points = box_mesh(size).corners;
        for (int i = 0; i < 40; ++i) {
            Eigen::Vector3d p = 0.5 * size.cwiseProduct(Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
            const int axis = random.index(3);
            p[axis] = random.uniform() < 0.5 ? -0.5 * size[axis] : 0.5 * size[axis];
            points.push_back(p);
        }
        for (std::size_t i = points.size() - 1; i > 0; --i) std::swap(points[i], points[static_cast<std::size_t>(random.index(static_cast<int>(i) + 1))]);
        const Eigen::AngleAxisd turn(random.uniform(0, 6), Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized());
        for (auto& p : points) p = turn * p;
        RC_ASSERT(std::abs(hull_volume(points) / size.prod() - 1) < 1e-5);
    }));
}

TEST(Supports, CornersAreFewAndFallShortByTheToleranceAtMost) {
    Supports supports(Supports::Directions::many);
    const TriangleMesh ball = icosphere(4);
    for (const auto& p : ball.corners) supports.add(0.5 * p);
    const auto all = supports.corners(0.02, 1000);
    const auto few = supports.corners(0.02, 20);
    EXPECT_EQ(few.size(), 20U);
    EXPECT_LT(all.size(), 200U);
    for (const auto& direction : icosphere(3).corners) {
        double reach = 0;
        for (const auto& p : all) reach = std::max(reach, direction.dot(p));
        EXPECT_GT(reach, 0.5 - 0.021);
    }
    EXPECT_TRUE(Supports(Supports::Directions::few).corners(0.01, 10).empty());
}

TEST(SolidLine, KnowsWhereItIsInside) {
    TriangleMesh two = box_mesh({2, 2, 2});
    append(two, box_mesh({2, 2, 2}), Eigen::Affine3d(Eigen::Translation3d(0, 0, 1.5)));  // they overlap
    append(two, box_mesh({2, 2, 2}), Eigen::Affine3d(Eigen::Translation3d(0, 0, 5)));
    const SolidLine line(two, 2, {0.1, 0.23, 77});
    for (const double z : {-0.9, 0.0, 0.9, 2.4, 4.1, 5.9}) EXPECT_TRUE(line.inside(z)) << z;
    for (const double z : {-1.1, 2.6, 3.9, 6.1}) EXPECT_FALSE(line.inside(z)) << z;
    EXPECT_FALSE(SolidLine(two, 0, {0, 0.3, 3.2}).inside(0));
    EXPECT_TRUE(SolidLine(two, 1, {0.3, 0, 0.2}).inside(0));
    TriangleMesh open = box_mesh({2, 2, 2});
    open.triangles.resize(4);
    EXPECT_FALSE(SolidLine(open, 2, {0.1, 0.9, 0}).inside(0) && SolidLine(open, 0, {0, 0.1, 0.2}).inside(0));
}

}  // namespace
}  // namespace roomfix
