#include "roomfix/geometry/lens_grid.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "roomfix/geometry/camera_model.hpp"

namespace roomfix {
namespace {

/// Strong and lopsided: no plumb_bob lens does this.
Eigen::Vector2d bent(const Eigen::Vector2d& ideal) {
    const Eigen::Vector2d p = (ideal - Eigen::Vector2d(330, 225)) / 320;
    const double r2 = p.squaredNorm();
    return ideal + Eigen::Vector2d(-28 * p.x() * r2 + 9 * p.x() * p.y() * p.y() + 5 * std::sin(2.2 * p.y()),
                                   -22 * p.y() * r2 - 7 * p.x() * p.x() * p.x() + 4 * std::cos(2.5 * p.x()));
}

LensGrid grid_of(double spacing) {
    std::vector<Eigen::Vector2d> seen, ideal;
    const int columns = static_cast<int>(680 / spacing) + 1, rows = static_cast<int>(520 / spacing) + 1;
    for (int i = 0; i < columns * rows; ++i) {
        ideal.emplace_back(-20 + spacing * (i % columns), -20 + spacing * (i / columns));
        seen.push_back(bent(ideal.back()));
    }
    const auto grid = LensGrid::create(columns, seen, ideal);
    EXPECT_TRUE(grid);
    return *grid;
}

TEST(LensGrid, CorrectsALensThatNoFormulaFits) {
    const LensGrid grid = grid_of(20);
    double squares = 0;
    int count = 0;
    for (double x = 5; x < 635; x += 7.3) {
        for (double y = 5; y < 475; y += 7.3) {
            const auto corrected = grid.corrected(bent({x, y}));
            ASSERT_TRUE(corrected);
            squares += (*corrected - Eigen::Vector2d(x, y)).squaredNorm();
            ++count;
        }
    }
    EXPECT_LT(std::sqrt(squares / count), 0.15);  // px; the goal
    // A quarter of that with half the spacing: what is left is that the pieces are straight.
    EXPECT_LT(std::abs((*grid_of(10).corrected(bent({100, 90})) - Eigen::Vector2d(100, 90)).norm()), 0.08);
}

TEST(LensGrid, BothDirectionsAgreeAndKnowTheirSlopes) {
    const LensGrid grid = grid_of(40);
    for (double x = 40; x < 600; x += 31.7) {
        for (double y = 40; y < 440; y += 29.3) {
            Eigen::Matrix2d back, forth;
            const auto ideal = grid.corrected({x, y}, &back);
            ASSERT_TRUE(ideal);
            const auto again = grid.distorted(*ideal, &forth);
            ASSERT_TRUE(again);
            EXPECT_LT((*again - Eigen::Vector2d(x, y)).norm(), 1e-9);
            EXPECT_LT((back * forth - Eigen::Matrix2d::Identity()).norm(), 1e-9);
        }
    }
    EXPECT_FALSE(grid.corrected({-100, 100}));
    EXPECT_FALSE(grid.corrected({std::nan(""), 100}));
}

TEST(LensGrid, ACameraUsesItLikeAnyOtherLens) {
    CameraModel model = make_camera_model(640, 480, 500, 500, 320, 240);
    model.grid = std::make_shared<const LensGrid>(grid_of(20));
    for (double x = 40; x < 600; x += 41) {
        for (double y = 40; y < 440; y += 37) {
            Eigen::Matrix2d by_pixel;
            const auto ray = unproject(model, {x, y}, &by_pixel);
            ASSERT_TRUE(ray);
            ProjectionJacobian by_point;
            const auto again = project(model, ray->homogeneous(), &by_point);
            ASSERT_TRUE(again);
            EXPECT_LT((*again - Eigen::Vector2d(x, y)).norm(), 1e-9);
            EXPECT_LT((by_point.leftCols<2>() * by_pixel - Eigen::Matrix2d::Identity()).norm(), 1e-9);
        }
    }
    EXPECT_FALSE(project(model, {3, 0, 1})) << "outside the grid";
    EXPECT_FALSE(rescaled(model, 320, 240)) << "a grid is of one resolution";
}

TEST(LensGrid, RefusesWhatIsNoGrid) {
    std::vector<Eigen::Vector2d> seen, ideal;
    for (int i = 0; i < 16; ++i) ideal.emplace_back(10 * (i % 4), 10 * (i / 4));
    seen = ideal;
    EXPECT_TRUE(LensGrid::create(4, seen, ideal));
    EXPECT_FALSE(LensGrid::create(5, seen, ideal));
    EXPECT_FALSE(LensGrid::create(0, {}, {}));
    std::swap(seen[5], seen[6]);
    EXPECT_FALSE(LensGrid::create(4, seen, ideal)) << "folded over";
    seen = ideal;
    for (auto& p : seen) p.x() = -p.x();
    EXPECT_FALSE(LensGrid::create(4, seen, ideal)) << "mirrored";
    seen = ideal;
    seen[3].x() = std::nan("");
    EXPECT_FALSE(LensGrid::create(4, seen, ideal));
}

}  // namespace
}  // namespace roomfix
