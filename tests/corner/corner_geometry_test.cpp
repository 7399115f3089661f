#include "roomfix/corner/corner_geometry.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "corner/corner_views.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/corner/chou1986.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {
namespace {

/// Straight up, but for a hair.
CornerView looking_up_from(const Eigen::Vector2d& place, double turn, double tilt) {
    CornerView view;
    view.place = place;
    view.corner_from_camera.col(2) = Eigen::Vector3d(std::sin(tilt), 0, std::cos(tilt));
    view.corner_from_camera.col(0) = Eigen::Vector3d(0, 1, 0);
    view.corner_from_camera.col(1) = view.corner_from_camera.col(2).cross(view.corner_from_camera.col(0));
    view.corner_from_camera = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix() * view.corner_from_camera;
    return view;
}

TEST(CornerGeometry, TheClosedFormAgreesWithThreeOrthogonalAnglesOn100000Poses) {
    Random random(1986);
    int compared = 0;
    double worst = 0;
    double worst_truth = 0;
    for (int i = 0; i < 100000; ++i) {
        Eigen::Vector2d place(random.uniform(0.1, 3), random.uniform(0.1, 3));
        const Eigen::Vector3d off(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4));
        double roll = random.uniform(-3.1, 3.1);
        if (i % 5 == 1) place.y() = place.x();  // on the bisector
        if (i % 5 == 2) roll = 0;               // the walls' edge may run along an image axis
        if (i % 5 == 3) roll = random.uniform(-1e-9, 1e-9);
        CornerView view = looking(place, i % 7 == 0 ? Eigen::Vector3d::Zero() : off, roll);  // the corner in the image centre
        if (i % 5 == 4) view = looking_up_from(0.2 * place, random.uniform(-3, 3), random.uniform(-1e-6, 1e-6));
        const auto rays = corner_rays(view, right_angle);
        if (!rays) continue;
        const CornerSolutions p3oa = solve_corner(*rays, right_angle);
        const auto published = chou1986_view(*rays);
        ASSERT_EQ(p3oa.count, 1) << i;
        ASSERT_TRUE(published) << i;
        worst = std::max(worst, difference(p3oa.views[0], *published));
        worst_truth = std::max(worst_truth, difference(p3oa.views[0], view));
        ++compared;
    }
    EXPECT_GT(compared, 99000);
    EXPECT_LT(worst, 1e-9);
    EXPECT_LT(worst_truth, 1e-9);
}

TEST(CornerGeometry, WhatIsDrawnIsFoundAgainForWallsAtAnyAngle) {
    EXPECT_TRUE(rc::check([] {
        const auto unit = [] { return *rc::gen::inRange(1, 1000) / 1000.0; };
        const double angle = 0.9 + 1.4 * unit();
        const double a = 0.2 + 2 * unit();
        const double b = 0.2 + 2 * unit();
        const Eigen::Vector2d place(a + b * std::cos(angle), b * std::sin(angle));
        const CornerView view = looking(place, {0.6 * unit() - 0.3, 0.6 * unit() - 0.3, 0.6 * unit() - 0.3}, 0.4 * unit() - 0.2);
        const auto rays = corner_rays(view, angle);
        RC_PRE(rays.has_value());
        const CornerSolutions found = solve_corner(*rays, angle);
        double best = 1;
        for (int i = 0; i < found.count; ++i) best = std::min(best, difference(found.views[static_cast<std::size_t>(i)], view));
        RC_ASSERT(best < 1e-8);
    }));
}

TEST(CornerGeometry, EveryLabellingIsACameraInsideARoom) {
    EXPECT_TRUE(rc::check([] {
        const auto unit = [] { return *rc::gen::inRange(1, 1000) / 1000.0; };
        const CornerView view = looking({0.3 + 2 * unit(), 0.3 + 2 * unit()}, {0, 0, 0}, unit() - 0.5);
        const auto rays = corner_rays(view, right_angle);
        RC_PRE(rays.has_value());
        // Seen from inside, each of the three lines may be the walls' edge: one labelling is the true one.
        int same = 0;
        for (const CornerRays& labelled : labellings(*rays)) {
            const CornerSolutions found = solve_corner(labelled, right_angle);
            RC_ASSERT(found.count == 1);
            RC_ASSERT(is_inside(found.views[0], right_angle));
            same += difference(found.views[0], view) < 1e-9;
        }
        RC_ASSERT(same == 1);
    }));
}

TEST(CornerGeometry, AnOutsideCornerIsNone) {
    // Where a wall sticks out into the room both edges of the ceiling run down: an arrow, no Y.
    CornerRays arrow;
    arrow.corner = {0, -0.2};
    arrow.directions = {Eigen::Vector2d(-0.9, 0.43).normalized(), Eigen::Vector2d(0.9, 0.43).normalized(), Eigen::Vector2d(0, 1)};
    for (const CornerRays& labelled : labellings(arrow)) EXPECT_EQ(solve_corner(labelled, right_angle).count, 0);
}

TEST(CornerGeometry, AMirroredPictureIsTheCornerSeenFromTheMirroredPlace) {
    const CornerView view = looking({0.8, 1.7}, {0.1, -0.05, 0}, 0.05);
    const auto rays = corner_rays(view, right_angle);
    ASSERT_TRUE(rays);
    CornerRays mirrored = *rays;
    mirrored.corner.x() *= -1;
    for (auto& d : mirrored.directions) d.x() *= -1;
    const CornerSolutions found = solve_corner(labellings(mirrored)[2], right_angle);
    ASSERT_EQ(found.count, 1);
    EXPECT_NEAR(found.views[0].place.x(), 1.7, 1e-9);
    EXPECT_NEAR(found.views[0].place.y(), 0.8, 1e-9);
}

}  // namespace
}  // namespace roomfix
