#include "roomfix/geometry/convex_hull.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

std::vector<Eigen::Vector2d> some_points(Random& random, int count) {
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < count; ++i)
        points.emplace_back(std::floor(6 * random.uniform()), std::floor(6 * random.uniform()));  // some lie on each other, or in a line
    return points;
}

double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

TEST(ConvexHull, HoldsAllPointsAndTurnsAtEachCorner) {
    Random random(5);
    for (int round = 0; round < 200; ++round) {
        const std::vector<Eigen::Vector2d> points = some_points(random, 12);
        const std::vector<Eigen::Vector2d> hull = hull_of(points);
        ASSERT_GE(hull.size(), 3U);
        for (std::size_t i = 0; i < hull.size(); ++i) {
            const Eigen::Vector2d& a = hull[i];
            const Eigen::Vector2d& b = hull[(i + 1) % hull.size()];
            EXPECT_GT(turn(a, b, hull[(i + 2) % hull.size()]), 0);
            for (const Eigen::Vector2d& p : points) EXPECT_GE(turn(a, b, p), 0);
        }
    }
}

TEST(ConvexHull, OfSortedPointsIsTheSame) {
    Random random(6);
    for (int round = 0; round < 200; ++round) {
        std::vector<Eigen::Vector2d> points = some_points(random, 3 + round % 10);
        const std::vector<Eigen::Vector2d> expected = hull_of(points);
        sort_nearly_sorted(points);
        EXPECT_TRUE(
            std::is_sorted(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); }));
        std::vector<Eigen::Vector2d> hull(points.size() + 1);
        hull.resize(static_cast<std::size_t>(convex_hull_of_sorted(points, hull)));
        EXPECT_EQ(hull, expected);
    }
}

}  // namespace
}  // namespace roomfix
