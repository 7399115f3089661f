#include "roomfix/calibrate/plumb_line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/simulate/room_shots.hpp"

namespace roomfix {
namespace {

std::vector<LongEdge> edges_seen(const CameraModel& camera, int pictures, std::uint64_t seed) {
    RoomRenderer renderer(camera, room_sensor(), {}, seed);
    Random random(seed);
    std::vector<LongEdge> edges;
    LumaImage picture;
    for (int i = 0; i < pictures; ++i) {
        const RoomShot shot = cluttered_shot(random);
        renderer.render(shot.scene, shot.map_from_camera, shot.light, static_cast<std::uint64_t>(i), picture);
        for (LongEdge& edge : long_edges(picture, static_cast<std::size_t>(i))) edges.push_back(std::move(edge));
    }
    return edges;
}

/// Largest distance (px) over the picture between where two lenses image the same ray, once the camera was turned to make up for the rest.
double apart(const CameraModel& a, const CameraModel& b) {
    double worst = 0;
    for (double v = 10; v < a.height; v += 20) {
        for (double u = 10; u < a.width; u += 20) {
            const auto ray = unproject(a, {u, v});
            const auto other = ray ? project(b, ray->homogeneous()) : std::nullopt;
            if (other) worst = std::max(worst, (*other - Eigen::Vector2d(u, v) - Eigen::Vector2d(b.cx - a.cx, b.cy - a.cy)).norm());
        }
    }
    return worst;
}

TEST(PlumbLine, FindsALensInPicturesOfFurnishedRooms) {
    const CameraModel start = make_camera_model(640, 480, 420, 420, 319.5, 239.5);
    double chi = 0;
    for (const double k1 : {-0.28, -0.12}) {
        const CameraModel truth = make_camera_model(640, 480, 420, 420, 325, 236, {k1, 0.07, 0.0003, -0.0003, 0});
        const auto found = straighten(edges_seen(truth, 8, 71), start);
        ASSERT_TRUE(found) << found.error().message;
        EXPECT_LT(found->rms, 0.2);
        EXPECT_GT(found->used, 30);
        EXPECT_LT(apart(truth, found->model), 0.1 * apart(truth, make_camera_model(640, 480, 420, 420, 325, 236)));
        for (const int i : {2, 3, 4, 5}) chi += std::pow(found->model.intrinsics()[i] - truth.intrinsics()[i], 2) / found->covariance(i, i);
    }
    EXPECT_LT(chi / 8, 5) << "errors are about as large as stated";
}

TEST(PlumbLine, StatesItsErrorsAsLargeAsTheyAre) {
    Random random(73);
    double nees = 0;
    constexpr int runs = 6;
    for (int run = 0; run < runs; ++run) {
        const CameraModel truth = make_camera_model(640, 480, 420, 420, random.uniform(310, 330), random.uniform(230, 250),
                                                    {random.uniform(-0.3, -0.05), random.uniform(0.04, 0.12), random.normal(3e-4), random.normal(3e-4), 0});
        const auto found = straighten(edges_seen(truth, 6, random.bits()), make_camera_model(640, 480, 420, 420, 319.5, 239.5));
        ASSERT_TRUE(found) << found.error().message;
        const Eigen::Matrix<double, 6, 1> off = (found->model.intrinsics() - truth.intrinsics()).segment<6>(2);
        nees += off.dot(found->covariance.block<6, 6>(2, 2).ldlt().solve(off)) / (6 * runs);
    }
    EXPECT_GT(nees, 0.3);
    EXPECT_LT(nees, 1.7) << "three standard deviations of a mean of six";
}

TEST(PlumbLine, AnEdgeIsFollowedOnce) {
    Random random(74);
    for (const double turned : {0.0, 0.02, 0.3, 0.785, 1.2, 1.55}) {
        const Eigen::Vector2d along(std::cos(turned), std::sin(turned)), normal(-along.y(), along.x());
        LumaImage picture(320, 240);
        for (int y = 0; y < 240; ++y) {
            for (int x = 0; x < 320; ++x) {
                const double off = normal.dot(Eigen::Vector2d(x - 160.3, y - 120.2));
                picture.row(y)[x] = static_cast<std::uint8_t>(std::lround(60 + 90 / (1 + std::exp(-off)) + random.normal(2)));
            }
        }
        const auto edges = long_edges(picture, 0);
        ASSERT_EQ(edges.size(), 1u) << "turned by " << turned << " rad";
        const double length = (edges[0].points.back() - edges[0].points.front()).norm();
        EXPECT_NEAR(static_cast<double>(edges[0].points.size()) / length, 1, 0.5) << "points per px, more on a diagonal";
        for (const Eigen::Vector2d& p : edges[0].points) EXPECT_NEAR(normal.dot(p - Eigen::Vector2d(160.3, 120.2)), 0, 0.6);
    }
}

TEST(PlumbLine, EdgesThatAreBentInTruthAreLeftOut) {
    const CameraModel truth = make_camera_model(640, 480, 420, 420, 325, 236, {-0.2, 0.06, 0, 0, 0});
    auto edges = edges_seen(truth, 8, 72);
    constexpr std::size_t arch_picture = 99;
    for (int i = 0; i < 6; ++i) {  // arches
        LongEdge arch;
        arch.picture = arch_picture;
        for (double x = 0; x < 200; x += 1.5) arch.points.emplace_back(150.0 + x + 10 * i, 100 + 40 * i + 12 * std::pow(x / 100 - 1, 2));
        edges.push_back(arch);
    }
    const auto found = straighten(edges, make_camera_model(640, 480, 420, 420, 319.5, 239.5));
    ASSERT_TRUE(found) << found.error().message;
    std::size_t arches = 0;
    for (const LongEdge& edge : found->edges) {
        if (edge.picture != arch_picture) continue;
        ++arches;
        EXPECT_FALSE(edge.used);
    }
    EXPECT_EQ(arches, 6u);
    EXPECT_NEAR(found->model.distortion[0], -0.2, 5 * std::sqrt(found->covariance(4, 4)));
}

TEST(PlumbLine, AnEdgeInSeveralPicturesCountsOnce) {
    const CameraModel truth = make_camera_model(640, 480, 420, 420, 325, 236, {-0.2, 0.06, 0, 0, 0});
    const auto edges = edges_seen(truth, 8, 72);
    auto twice = edges;
    for (LongEdge edge : edges) {
        edge.picture += 8;
        twice.push_back(edge);
    }
    const auto once = straighten(edges, truth), again = straighten(twice, truth);
    ASSERT_TRUE(once && again);
    EXPECT_EQ(once->used, again->used);
    EXPECT_NEAR(once->covariance(4, 4), again->covariance(4, 4), 1e-3 * once->covariance(4, 4));
}

TEST(PlumbLine, SaysWhatIsMissing) {
    const CameraModel start = make_camera_model(640, 480, 420, 420, 319.5, 239.5);
    EXPECT_NE(straighten({}, start).error().message.find("0 long edges"), std::string::npos);
    const std::vector<LongEdge> stubs(20, LongEdge{{{1, 2}, {3, 4}, {5, 6}}});
    EXPECT_NE(straighten(stubs, start).error().message.find("0 long edges"), std::string::npos);
    std::vector<LongEdge> middle;  // all through the middle: they are straight for any lens
    for (int i = 0; i < 20; ++i) {
        LongEdge edge;
        const Eigen::Vector2d along(std::cos(0.15 * i), std::sin(0.15 * i));
        for (double x = -60; x < 60; x += 1.5)
            edge.points.emplace_back(Eigen::Vector2d(319.5, 239.5) + x * along + 0.05 * std::sin(37 * x + i) * Eigen::Vector2d(-along.y(), along.x()));
        middle.push_back(edge);
    }
    const auto unknown = straighten(middle, start);
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find("border"), std::string::npos) << unknown.error().message;
    EXPECT_TRUE(long_edges(LumaView{}, 0).empty());
}

TEST(PlumbLine, GrowsWithTheFocalLengthsError) {
    PlumbLine found;
    found.model = make_camera_model(640, 480, 400, 400, 320, 240, {-0.2, 0.05, 0, 0, 0});
    IntrinsicsMatrix known = IntrinsicsMatrix::Zero();
    known.topLeftCorner<2, 2>().setConstant(16);  // 1 %, both alike
    const IntrinsicsMatrix all = covariance_with_focal(found, known);
    EXPECT_NEAR(std::sqrt(all(4, 4)), 0.2 * 0.02, 1e-12) << "k1 goes with the square";
    EXPECT_NEAR(std::sqrt(all(5, 5)), 0.05 * 0.04, 1e-12);
}

}  // namespace
}  // namespace roomfix
