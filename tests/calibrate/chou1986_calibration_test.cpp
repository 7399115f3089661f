#include "roomfix/calibrate/chou1986_calibration.hpp"

#include <gtest/gtest.h>

#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {
namespace {

TEST(Chou1986Calibration, AGridAtAKnownDistanceGivesTheFocalLength) {
    const CameraModel plain = make_camera_model(640, 480, 600, 600, 320, 240);
    const Chessboard grid{21, 15, 0.03};
    std::vector<Eigen::Vector2d> seen;
    for (int i = 0; i < grid.corners(); ++i) {
        const Eigen::Vector2d p = grid.corner(i) - 0.5 * grid.corner(grid.corners() - 1);
        seen.push_back(*project(plain, {p.x(), p.y(), 0.8}));
    }
    const auto ideal = ideal_grid(seen, grid, {320, 240});
    ASSERT_TRUE(ideal) << ideal.error().message;
    EXPECT_NEAR(*focal_length(ideal->spacing, 0.8, grid.square), 600, 1e-6);
    for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_LT((ideal->points[i] - seen[i]).norm(), 1e-6);
    EXPECT_FALSE(focal_length(20, 0, 0.03));
    seen.pop_back();
    EXPECT_FALSE(ideal_grid(seen, grid, {320, 240})) << "half out of view";
}

TEST(Chou1986Calibration, LinesAlongTheViewMeetInTheImageCentre) {
    const CameraModel plain = make_camera_model(640, 480, 600, 600, 331, 229);
    const auto at = [&](double y, double z) { return *project(plain, {-1.2, y, z}); };  // a wall on the left
    const auto centre = image_centre(at(-0.5, 3), at(-0.5, 6), at(0.6, 3), at(0.6, 6));
    ASSERT_TRUE(centre);
    EXPECT_LT((*centre - Eigen::Vector2d(331, 229)).norm(), 1e-9);
    EXPECT_FALSE(image_centre({0, 0}, {10, 0}, {0, 5}, {10, 5})) << "parallel in the picture: the wall is not along the view";
    EXPECT_FALSE(image_centre({0, 0}, {0, 0}, {0, 5}, {10, 5}));
}

TEST(Chou1986Calibration, ResamplesTheWholePicture) {
    LumaImage seen(64, 48);
    for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 64; ++x) seen.row(y)[x] = static_cast<std::uint8_t>(3 * x);
    }
    std::vector<Eigen::Vector2d> ideal, moved;
    for (int i = 0; i < 20; ++i) {
        ideal.emplace_back(14 * (i % 5), 14 * (i / 5));
        moved.push_back(ideal.back() + Eigen::Vector2d(2.5, 0));
    }
    const auto grid = LensGrid::create(5, moved, ideal);
    ASSERT_TRUE(grid);
    LumaImage corrected;
    correct_picture(seen, *grid, corrected);
    EXPECT_NEAR(corrected.row(20)[30], 3 * 32.5, 1);
    EXPECT_EQ(corrected.row(20)[62], 0) << "outside the grid";
}

}  // namespace
}  // namespace roomfix
