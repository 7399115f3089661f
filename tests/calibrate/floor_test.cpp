#include "roomfix/calibrate/floor.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/calibrate/tile_grid.hpp"
#include "roomfix/simulate/camera_renderer.hpp"

namespace roomfix {
namespace {

constexpr double tile = 0.3;

CameraModel floor_camera() { return make_camera_model(640, 480, 518, 518, 320.5, 238, {-0.1, 0.02, 0.0005, -0.001, 0}); }

/// Looks along a floor; the tile clicked is about three metres away.
Eigen::Isometry3d true_pose(Random& random) {
    return looking_at({random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(2.2, 2.6)},
                      {random.uniform(3.5, 4.5), random.uniform(-0.3, 0.3), 0});
}

FloorSource clicked_tile(const View& truth, double noise, Random& random) {
    FloorSource clicks{"four clicks"};
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(3, 0), {3.3, 0}, {3.3, 0.3}, {3, 0.3}}) {
        const Eigen::Vector2d pixel = *project_map_point(truth, {corner.x(), corner.y(), 0});
        clicks.sightings.push_back(clicked_point(pixel + Eigen::Vector2d(random.normal(noise), random.normal(noise)), corner, noise));
    }
    return clicks;
}

TEST(CalibrateFloor, FourClicksOnATileKnowHowGoodTheyAre) {
    // NEES of six unknowns over 200 runs: 6 +- 4 * sqrt(2 * 6 / 200) is a false alarm in 1e-4; the tail is not quite Gaussian.
    Random random(3);
    double sum = 0;
    int doubtful = 0;
    constexpr int runs = 200;
    for (int i = 0; i < runs; ++i) {
        const View truth{floor_camera(), {true_pose(random), Matrix6d::Zero()}};
        const auto found = calibrate_floor(floor_camera(), IntrinsicsMatrix::Zero(), {clicked_tile(truth, 0.5, random)});
        ASSERT_TRUE(found) << found.error().message;
        if (found->rival) {  // it knows that it may be elsewhere
            ++doubtful;
            continue;
        }
        const Vector6d off = error_between(truth.map_from_camera.pose, found->map_from_camera.pose);
        sum += off.dot(found->map_from_camera.covariance.inverse() * off);
        EXPECT_GT(found->floor_error, 0.02) << "one tile alone is not much";
    }
    EXPECT_LT(doubtful, runs / 3);
    EXPECT_NEAR(sum / (runs - doubtful), 6, 1.5);
    RecordProperty("doubtful", doubtful);
}

TEST(CalibrateFloor, TheTileGridMakesCentimetresOfDecimetres) {
    Random random(5);
    double squares = 0, stated = 0, clicks_alone = 0;
    constexpr int runs = 4;
    for (int i = 0; i < runs; ++i) {
        const View truth{floor_camera(), {true_pose(random), Matrix6d::Zero()}};
        LumaImage picture;
        CameraRenderer(Scene{}, truth, {}, static_cast<std::uint64_t>(i)).render({}, 1, 0, picture);
        const FloorSource clicks = clicked_tile(truth, 0.5, random);
        const auto start = calibrate_floor(floor_camera(), IntrinsicsMatrix::Zero(), {clicks});
        ASSERT_TRUE(start);
        const FloorSource joints = find_tile_grid(picture, {floor_camera(), start->map_from_camera}, {{3, 0, 0}, tile}, {clicks});
        const auto found = calibrate_floor(floor_camera(), IntrinsicsMatrix::Zero(), {clicks, joints}, start->map_from_camera);
        ASSERT_TRUE(found) << found.error().message;
        EXPECT_GT(joints.sightings.size(), 200U);
        // Floor six metres away, by the found pose.
        const View view{floor_camera(), found->map_from_camera};
        const Eigen::Vector2d pixel = *project_map_point(truth, {6, 0.2, 0});
        const double off = (pixel_to_plane(view, pixel, 0)->point - Eigen::Vector2d(6, 0.2)).norm();
        EXPECT_LT(off, 0.01) << i;
        squares += off * off;
        stated += std::pow(*floor_sigma(view, pixel), 2);
        clicks_alone += start->floor_error / runs;
        EXPECT_GT(found->contributions[1].share, 0.9);
        ASSERT_TRUE(found->contributions[0].alone);
        EXPECT_GT(*found->contributions[0].alone, 5 * found->floor_error);
    }
    EXPECT_GT(clicks_alone, 0.03);
    EXPECT_LT(std::sqrt(squares / runs), 3 * std::sqrt(stated / runs));
}

TEST(CalibrateFloor, ErrorsOfTheLensGoIntoTheFloor) {
    // The camera is calibrated with a lens that is off: floor errors are as large as the joint covariance says.
    Random random(7);
    IntrinsicsMatrix uncertain = IntrinsicsMatrix::Zero();
    const IntrinsicsVector sigma = (IntrinsicsVector() << 4, 4, 3, 3, 0.01, 0.005, 0, 0, 0, 0, 0, 0).finished();
    uncertain.diagonal() = sigma.cwiseAbs2();
    double sum = 0;
    constexpr int runs = 150;
    for (int i = 0; i < runs; ++i) {
        const View truth{floor_camera(), {true_pose(random), Matrix6d::Zero()}};
        CameraModel wrong = floor_camera();
        IntrinsicsVector numbers = wrong.intrinsics();
        for (int k = 0; k < 6; ++k) numbers[k] += random.normal(sigma[k]);
        wrong.set_intrinsics(numbers);
        FloorSource clicks{"clicks"};
        for (const double x : {2.2, 3.5, 6.0}) {
            for (const double y : {-0.9, 0.2, 0.9}) {
                const Eigen::Vector2d pixel = *project_map_point(truth, {x, y, 0});
                clicks.sightings.push_back(clicked_point(pixel + Eigen::Vector2d(random.normal(0.5), random.normal(0.5)), {x, y}, 0.5));
            }
        }
        const auto found = calibrate_floor(wrong, uncertain, {clicks});
        ASSERT_TRUE(found) << found.error().message;
        const View view{wrong, found->map_from_camera, {uncertain, found->by_intrinsics}};
        const Eigen::Vector2d at(7.5, 0.5), pixel = *project_map_point(truth, {at.x(), at.y(), 0});
        const auto floor = pixel_to_plane(view, pixel, 0);
        const auto by = plane_point_by_calibration(view, *floor, 0);
        const Eigen::Vector2d off = floor->point - at;
        sum += off.dot((*by * by->transpose()).inverse() * off);
    }
    EXPECT_NEAR(sum / runs, 2, 0.7);  // +-4 standard deviations of the mean of chi-square with 2 is 0.65
}

TEST(CalibrateFloor, CombinesByCovarianceAndSaysWhatEachIsWorth) {
    Random random(9);
    const View truth{floor_camera(), {true_pose(random), Matrix6d::Zero()}};
    FloorSource corner{"corner nw"};
    Vector6d off;
    for (int i = 0; i < 6; ++i) off[i] = random.normal(0.003);
    corner.pose = UncertainPose3{perturbed(truth.map_from_camera.pose, off), 9e-6 * Matrix6d::Identity()};
    const auto both = calibrate_floor(floor_camera(), IntrinsicsMatrix::Zero(), {clicked_tile(truth, 0.5, random), corner});
    ASSERT_TRUE(both) << both.error().message;
    ASSERT_EQ(both->contributions.size(), 2U);
    EXPECT_NEAR(both->contributions[0].share + both->contributions[1].share, 1, 1e-9);
    EXPECT_LT(both->floor_error, *both->contributions[0].alone);
    EXPECT_LT(both->floor_error, *both->contributions[1].alone);
    const auto alone = calibrate_floor(floor_camera(), IntrinsicsMatrix::Zero(), {corner});
    ASSERT_TRUE(alone) << "a corner alone tells the whole pose";
}

TEST(CalibrateFloor, SaysWhatIsMissing) {
    Random random(11);
    const View truth{floor_camera(), {true_pose(random), Matrix6d::Zero()}};
    const FloorSource tile_clicks = clicked_tile(truth, 0.5, random);
    const auto expect_error = [](const std::vector<FloorSource>& sources, const char* words) {
        const auto found = calibrate_floor(floor_camera(), IntrinsicsMatrix::Zero(), sources);
        ASSERT_FALSE(found);
        EXPECT_NE(found.error().message.find(words), std::string::npos) << found.error().message;
    };
    expect_error({}, "nothing tells where the camera is");
    FloorSource three = tile_clicks;
    three.sightings.pop_back();
    expect_error({three}, "four or more are needed");
    FloorSource mirrored = tile_clicks;
    std::reverse(mirrored.sightings.begin(), mirrored.sightings.end());
    for (std::size_t i = 0; i < 4; ++i) mirrored.sightings[i].map = tile_clicks.sightings[i].map;
    expect_error({mirrored}, "check their order");
    FloorSource line = tile_clicks;
    for (std::size_t i = 0; i < 4; ++i) {
        line.sightings[i].map = {3 + 0.3 * static_cast<double>(i), 0};
        line.sightings[i].pixel = *project_map_point(truth, {line.sightings[i].map.x(), 0, 0});
    }
    expect_error({line}, "on one line");
    // A picture without joints adds nothing and does no harm.
    LumaImage grey(640, 480);
    for (int y = 0; y < 480; ++y) std::fill_n(grey.row(y), 640, std::uint8_t{120});
    const auto start = calibrate_floor(floor_camera(), IntrinsicsMatrix::Zero(), {tile_clicks});
    ASSERT_TRUE(start);
    EXPECT_TRUE(find_tile_grid(grey, {floor_camera(), start->map_from_camera}, {{3, 0, 0}, tile}, {tile_clicks}).sightings.empty());
}

}  // namespace
}  // namespace roomfix
