#include "roomfix/corner/line_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

constexpr int reduction = 2;
const CameraModel bending_lens = make_camera_model(640, 480, 500, 500, 320, 240, {-0.25, 0.06});

/// A stretch of a line in the picture without its lens, in focal lengths; the brighter side lies to the right of the way from `from` to `to` on the screen.
struct Stroke {
    Eigen::Vector2d from, to;

    Eigen::Vector2d normal() const {
        const Eigen::Vector2d along = (to - from).normalized();
        return {-along.y(), along.x()};
    }
    double distance() const { return normal().dot(from); }
};

/// Its edge points as the lens shows them, one for each reduced pixel.
void draw(const Stroke& stroke, Random& random, std::vector<EdgePoint>& points) {
    const int count = static_cast<int>((stroke.to - stroke.from).norm() * bending_lens.fx / reduction);
    for (int i = 0; i < count; ++i) {
        const auto at = [&](double part) { return *project(bending_lens, Eigen::Vector2d(stroke.from + part * (stroke.to - stroke.from)).homogeneous()); };
        const double part = (i + 0.5) / count;
        const Eigen::Vector2d along = (at(part + 1e-3) - at(part - 1e-3)).normalized();
        const Eigen::Vector2d normal(-along.y(), along.x());
        const Eigen::Vector2d pixel = at(part) + random.normal(0.3) * normal;
        const Eigen::Vector2d turned = Eigen::Rotation2Dd(random.normal(0.05)) * normal;
        points.push_back({static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), static_cast<float>(turned.x()), static_cast<float>(turned.y()), 10});
    }
}

/// Points anywhere, with any direction.
void scatter(int count, Random& random, std::vector<EdgePoint>& points) {
    for (int i = 0; i < count; ++i) {
        const double direction = random.uniform(-3.14159, 3.14159);
        points.push_back({static_cast<float>(random.uniform(0, 639)), static_cast<float>(random.uniform(0, 479)), static_cast<float>(std::cos(direction)),
                          static_cast<float>(std::sin(direction)), static_cast<float>(random.uniform(3, 10))});
    }
}

std::vector<SceneLine> find_lines(const std::vector<EdgePoint>& points) {
    LineSearch search(bending_lens);
    std::vector<SceneLine> lines;
    search.find(points, reduction, lines);
    return lines;
}

TEST(LineSearch, FindsStraightLinesThatTheLensBends) {
    Random random(41);
    const std::vector<Stroke> strokes = {{{-0.5, -0.35}, {0.4, -0.3}}, {{0.45, -0.3}, {0.2, 0.35}}, {{-0.45, 0.3}, {-0.2, -0.1}}};
    std::vector<EdgePoint> points;
    for (const Stroke& stroke : strokes) draw(stroke, random, points);
    scatter(400, random, points);
    const std::vector<SceneLine> lines = find_lines(points);
    EXPECT_EQ(lines.size(), strokes.size()) << "points that lie anywhere make no line";
    for (const Stroke& stroke : strokes) {
        const auto found = std::find_if(lines.begin(), lines.end(), [&](const SceneLine& line) {
            return line.normal.dot(stroke.normal()) > std::cos(0.01) && std::abs(line.distance - stroke.distance()) * bending_lens.fx < 2;
        });
        ASSERT_NE(found, lines.end()) << stroke.from.transpose();
        const double length = (stroke.to - stroke.from).norm();
        EXPECT_GT(found->points, 0.9 * length * bending_lens.fx / reduction);
        EXPECT_NEAR(found->density, 1, 0.2);
        const double begin = found->along().dot(stroke.from), end = found->along().dot(stroke.to);
        EXPECT_NEAR(found->covered(begin, end), length, 3 * found->cell);
        EXPECT_NEAR(found->covered(end, begin), length, 3 * found->cell) << "either way";
    }
    EXPECT_TRUE(std::is_sorted(lines.begin(), lines.end(), [](const SceneLine& a, const SceneLine& b) { return a.points > b.points; }));
}

TEST(LineSearch, AGapInALineIsNotCovered) {
    Random random(42);
    std::vector<EdgePoint> points;
    draw({{-0.5, 0}, {-0.1, 0}}, random, points);
    draw({{0.1, 0}, {0.5, 0}}, random, points);
    const std::vector<SceneLine> lines = find_lines(points);
    ASSERT_EQ(lines.size(), 1U);
    const double sign = lines[0].along().x();
    EXPECT_NEAR(lines[0].covered(-0.5 * sign, 0.5 * sign), 0.8, 4 * lines[0].cell);
    EXPECT_NEAR(lines[0].covered(-0.07 * sign, 0.07 * sign), 0, 1e-9);
    EXPECT_NEAR(lines[0].density, 0.8, 0.1);
    const auto ends = lines[0].ends();
    EXPECT_NEAR(std::min(ends[0].x(), ends[1].x()), -0.5, 2 * lines[0].cell);
    EXPECT_NEAR(std::max(ends[0].x(), ends[1].x()), 0.5, 2 * lines[0].cell);
}

TEST(LineSearch, DarkToBrightAndBrightToDarkAreTwoLines) {
    Random random(43);
    std::vector<EdgePoint> points;
    draw({{-0.5, 0}, {0.5, 0}}, random, points);
    draw({{0.5, 0.006}, {-0.5, 0.006}}, random, points);  // a cable, 3 px wide
    const std::vector<SceneLine> lines = find_lines(points);
    ASSERT_EQ(lines.size(), 2U);
    EXPECT_LT(lines[0].normal.dot(lines[1].normal), -0.99);
}

TEST(LineSearch, PointsAnywhereMakeNoLine) {
    Random random(44);
    for (const int count : {0, 1, 100, 3000}) {
        std::vector<EdgePoint> points;
        scatter(count, random, points);
        EXPECT_TRUE(find_lines(points).empty()) << count;
    }
}

}  // namespace
}  // namespace roomfix
