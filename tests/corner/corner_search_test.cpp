#include "roomfix/corner/corner_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "corner/corner_views.hpp"
#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

const CameraModel pinhole = make_camera_model(640, 480, 500, 500, 320, 240);

/// An edge of the room as the line search tells it, from one point of the picture (focal lengths) to another.
SceneLine line_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    SceneLine line;
    const Eigen::Vector2d along = (to - from).normalized();
    line.normal = {along.y(), -along.x()};
    line.distance = line.normal.dot(from);
    line.cell = 8 / pinhole.fx;
    line.first = -0.5 * SceneLine::cells * line.cell;
    const auto cell_of = [&](const Eigen::Vector2d& point) { return static_cast<int>(std::floor((line.along().dot(point) - line.first) / line.cell)); };
    line.first_filled = std::min(cell_of(from), cell_of(to));
    line.last_filled = std::max(cell_of(from), cell_of(to));
    for (int i = 0; i < SceneLine::cells; ++i) {
        const bool filled = i >= line.first_filled && i <= line.last_filled;
        line.filled[static_cast<std::size_t>(i) + 1] = static_cast<std::int16_t>(line.filled[static_cast<std::size_t>(i)] + filled);
    }
    line.points = 4 * (line.last_filled - line.first_filled + 1);
    line.density = 1;
    return line;
}

/// The three edges of a corner, `length` focal lengths of each.
std::vector<SceneLine> lines_of(const CornerView& view, double wall_angle, double length = 0.3) {
    const CornerRays rays = *corner_rays(view, wall_angle);
    std::vector<SceneLine> lines;
    for (const Eigen::Vector2d& direction : rays.directions) lines.push_back(line_between(rays.corner, rays.corner + length * direction));
    return lines;
}

CornerSearchResult search(const std::vector<SceneLine>& lines, const std::optional<Gravity>& gravity = {}, double wall_angle = right_angle) {
    CornerSearchResult result;
    CornerSearch(pinhole, {wall_angle}).find(lines, gravity, result);
    return result;
}

bool has(const CornerSearchResult& result, const CornerView& view) {
    return std::any_of(result.candidates.begin(), result.candidates.end(), [&](const CornerCandidate& c) { return difference(c.view, view) < 0.01; });
}

TEST(CornerSearch, FindsTheCornerOfEveryY) {
    Random random(51);
    int looked = 0;
    for (int i = 0; i < 200; ++i) {
        const double angle = i % 2 == 0 ? right_angle : random.uniform(1.2, 2.2);
        const CornerView view =
            looking({random.uniform(0.5, 2), random.uniform(0.5, 2)}, {random.uniform(-0.15, 0.15), random.uniform(-0.15, 0.15), 0}, random.uniform(-0.3, 0.3));
        const auto rays = corner_rays(view, angle);
        if (!rays || !is_inside(view, angle)) continue;
        std::array<double, 3> between{};
        for (std::size_t k = 0; k < 3; ++k) between[k] = std::acos(rays->directions[k].dot(rays->directions[(k + 1) % 3]));
        if (*std::min_element(between.begin(), between.end()) < 0.4) continue;  // edges that hide behind each other
        EXPECT_TRUE(has(search(lines_of(view, angle), {}, angle), view)) << i;
        ++looked;
    }
    EXPECT_GT(looked, 100);
}

TEST(CornerSearch, TwoLinesAreAJunctionThatLacksAThird) {
    const CornerView view = looking({1.1, 1.4}, {0.05, -0.04, 0}, 0.1);
    std::vector<SceneLine> lines = lines_of(view, right_angle);
    lines.pop_back();
    const CornerSearchResult result = search(lines);
    EXPECT_TRUE(result.candidates.empty());
    ASSERT_EQ(result.junctions.size(), 1U);
    const CornerRays rays = *corner_rays(view, right_angle);
    EXPECT_LT((result.junctions[0].point - rays.corner).norm(), 1e-9);
    EXPECT_TRUE(starts_edges(result.junctions[0], rays, 0.01));
    const CornerRays turned = *corner_rays(looking({1.1, 1.4}, {0.05, -0.04, 0}, 0.3), right_angle);
    EXPECT_FALSE(starts_edges(result.junctions[0], turned, 0.01));
}

TEST(CornerSearch, LinesThatGoOnBeyondTheirMeetingPointAreLessLikelyACorner) {
    const CornerView view = looking({1.1, 1.4}, {0.05, -0.04, 0}, 0.1);
    const CornerRays rays = *corner_rays(view, right_angle);
    std::vector<SceneLine> crossing = lines_of(view, right_angle);
    crossing[0] = line_between(rays.corner - 0.2 * rays.directions[0], rays.corner + 0.3 * rays.directions[0]);
    const CornerSearchResult corner = search(lines_of(view, right_angle)), cross = search(crossing);
    ASSERT_TRUE(has(corner, view));
    ASSERT_TRUE(has(cross, view));
    EXPECT_LT(cross.candidates[0].score, corner.candidates[0].score - 20);
}

TEST(CornerSearch, LinesThatDoNotMeetAreNone) {
    const CornerView view = looking({1.1, 1.4}, {0.05, -0.04, 0}, 0.1);
    std::vector<SceneLine> lines = lines_of(view, right_angle);
    lines[2].distance += 12 / pinhole.fx;
    EXPECT_TRUE(search(lines).candidates.empty());
    EXPECT_TRUE(search({}).candidates.empty());
}

TEST(CornerSearch, ThirdLinesThatStartElsewhereAreNone) {
    const CornerView view = looking({1.1, 1.4}, {0.05, -0.04, 0}, 0.1);
    const CornerRays rays = *corner_rays(view, right_angle);
    std::vector<SceneLine> lines = lines_of(view, right_angle);
    lines[2] = line_between(rays.corner + 0.2 * rays.directions[2], rays.corner + 0.4 * rays.directions[2]);
    EXPECT_TRUE(search(lines).candidates.empty()) << "100 px of it are missing";
}

TEST(CornerSearch, WhereDownIsKnownNoOtherCornerIsRead) {
    const CornerView view = looking({1.1, 1.4}, {0.05, -0.04, 0}, 0.1);
    const Eigen::Vector3d down = -view.corner_from_camera.row(2).transpose();
    EXPECT_TRUE(has(search(lines_of(view, right_angle), Gravity{down, 0.02}), view));
    const Eigen::Vector3d elsewhere = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()) * down;
    EXPECT_FALSE(has(search(lines_of(view, right_angle), Gravity{elsewhere, 0.02}), view));
}

}  // namespace
}  // namespace roomfix
