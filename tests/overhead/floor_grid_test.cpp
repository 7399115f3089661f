#include "roomfix/overhead/floor_grid.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/random.hpp"
#include "standing_camera.hpp"

namespace roomfix {
namespace {

/// A camera in the corner of a room of 6 x 5 m.
View corner_camera(double x) { return standing_camera(make_camera_model(640, 480, 450, 450, 320, 240), {x, 0.1, 2.5}, {3, 2.5, 0}); }

Evidence empty_picture() {
    Evidence evidence;
    evidence.width = 640;
    evidence.height = 480;
    return evidence;
}

class FloorGridTest : public ::testing::Test {
protected:
    const View left = corner_camera(0.1), right = corner_camera(5.9);
    const Evidence evidence = empty_picture();
    std::vector<Polyline> walls = {{{0, 0}, {6, 0}, {6, 5}, {0, 5}, {0, 0}}};
    const std::vector<SeenBy> cameras = {{&left, &evidence, &walls}, {&right, &evidence, &walls}};
    const Body body = body_of(SiteRobot{"can", Cylinder{0.45, 1.2}});
    const FloorGridSettings settings{0.1, 40000, 8};
};

TEST_F(FloorGridTest, ABodyLiesInsideOfTheBoxesOfThePlaceNextToIt) {
    FloorGrid grid;
    grid.lay(cameras, body, settings);
    Random random(4);
    BodyMask mask;
    for (int i = 0; i < 100; ++i) {
        const Pose2 pose{0.6 + 4.8 * random.uniform(), 0.6 + 3.8 * random.uniform(), 0};
        std::size_t nearest = 0;
        const auto apart = [&](std::size_t p) { return (grid.places()[p] - Eigen::Vector2d(pose.x, pose.y)).norm(); };
        for (std::size_t p = 0; p < grid.places().size(); ++p) nearest = apart(p) < apart(nearest) ? p : nearest;
        ASSERT_LT(apart(nearest), 0.08);
        for (std::size_t c = 0; c < cameras.size(); ++c) {
            cover(*cameras[c].view, body.parts, {grid.places()[nearest].x(), grid.places()[nearest].y(), 0}, 640, 480, 1, 1, mask);
            const FloorGrid::Box& box = grid.boxes(nearest)[c];
            double outside = 0;
            for (const Span& s : mask.spans) {
                const int inside = std::max(std::min<int>(s.end, box.right) - std::max<int>(s.begin, box.left), 0);
                outside += s.end - s.begin - (s.y >= box.above && s.y < box.below ? inside : 0);
            }
            EXPECT_LT(outside, 0.15 * mask.area) << "camera " << c << " at " << grid.places()[nearest].transpose();
        }
    }
}

TEST_F(FloorGridTest, HasNoPlacesBehindWallsAndEachPlaceInOnePatch) {
    FloorGrid grid;
    grid.lay(cameras, body, settings);
    ASSERT_GT(grid.places().size(), 1000U);
    for (const Eigen::Vector2d& place : grid.places()) {
        EXPECT_GT(place.minCoeff(), -0.6);
        EXPECT_LT(place.x(), 6.6);
        EXPECT_LT(place.y(), 5.6);
    }
    std::size_t next = 0;
    for (const FloorGrid::Patch& patch : grid.patches()) {
        EXPECT_EQ(patch.begin, next);
        next = patch.end;
        for (std::size_t p = patch.begin; p < patch.end; ++p) EXPECT_LT((grid.places()[p] - patch.middle).norm(), 0.2);
    }
    EXPECT_EQ(next, grid.places().size());
}

TEST_F(FloorGridTest, FitsAsLongAsCamerasWallsAndBodyAreTheSame) {
    FloorGrid grid;
    grid.lay(cameras, body, settings);
    EXPECT_TRUE(grid.fits(cameras, body, settings));
    EXPECT_FALSE(grid.fits({cameras.data(), 1}, body, settings));
    EXPECT_FALSE(grid.fits(cameras, body_of(SiteRobot{"can", Cylinder{0.45, 1.3}}), settings));
    View moved = right;
    moved.map_from_camera.pose.translation().x() += 0.01;
    EXPECT_FALSE(grid.fits(std::vector<SeenBy>{cameras[0], {&moved, &evidence, &walls}}, body, settings));
    walls[0][2].x() = 5;
    EXPECT_FALSE(grid.fits(cameras, body, settings));
}

}  // namespace
}  // namespace roomfix
