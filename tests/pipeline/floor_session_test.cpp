#include "roomfix/pipeline/floor_session.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/simulate/room_shots.hpp"
#include "roomfix/simulate/tag_scene.hpp"

namespace roomfix {
namespace {

Site lab() {
    Site site;
    site.name = "lab";
    site.robots = {{"r1", Box{0.5, 0.5, 0.5}}};
    return site;
}

double squared_distance(const FloorCalibration& found, const Eigen::Isometry3d& truth) {
    const Vector6d off = error_between(truth, found.map_from_camera.pose);
    return off.dot(found.map_from_camera.covariance.inverse() * off);
}

TEST(FloorSession, TagsOnTheFloorTellWhereTheCameraIs) {
    Random random(3);
    Site site = lab();
    const View truth{make_camera_model(640, 480, 520, 521, 322, 238, {-0.1, 0.02, 0.0005, -0.001, 0}),
                     {looking_at({0, 0, 2.4}, {3, 0.3, 0}), Matrix6d::Zero()}};
    LumaImage picture(640, 480);
    for (int y = 0; y < 480; ++y) std::fill_n(picture.row(y), 640, std::uint8_t{110});
    const Eigen::Vector2d places[] = {{2.2, -0.6}, {2.4, 0.9}, {4.2, 0.2}};
    for (int i = 0; i < 3; ++i) {
        SiteLandmark tag{"t" + std::to_string(i), Tag{i + 1, 0.3}};
        tag.map_from_landmark.translation() << places[i], 0;
        tag.sigma = 0.001;
        site.landmarks.push_back(tag);
        // Laid out a little beside where the site file has it.
        Eigen::Isometry3d laid = tag.map_from_landmark;
        laid.translation().head<2>() += Eigen::Vector2d(random.normal(tag.sigma), random.normal(tag.sigma));
        paint_tag(truth, laid, Tag{i + 1, 0.3}, 1.5, static_cast<std::uint64_t>(i), picture);
    }
    const SiteCamera camera{"hall", "", truth.model, KnownPose{}};
    const auto session = calibrate_floor_from(site, camera, picture, {});
    ASSERT_TRUE(session) << session.error().message;
    EXPECT_EQ(session->calibration.contributions.size(), 3U);
    EXPECT_LT((session->calibration.map_from_camera.pose.translation() - truth.position()).norm(), 0.02);
    EXPECT_LT(squared_distance(session->calibration, truth.map_from_camera.pose), 27);  // chi-square with 6: one in 1e4
    // A tag on the wall is not on the floor.
    for (SiteLandmark& landmark : site.landmarks) landmark.map_from_landmark.translation().z() = 1;
    EXPECT_FALSE(calibrate_floor_from(site, camera, picture, {}));
}

TEST(FloorSession, ACornerAndTheHeightTellWhereTheCameraIs) {
    Random random(5);
    const RoomShot shot = chou1986_shot({2.0, 1.5}, random);
    RoomRenderer renderer(room_camera(), room_sensor(), {}, 9);
    LumaImage picture;
    renderer.render(shot.scene, shot.map_from_camera, shot.light, 0, picture);
    Site site = lab();
    SiteCorner corner = shot.corner;
    corner.id = "nw";
    site.corners = {corner};
    const SiteCamera camera{"hall", "", room_camera(), KnownPose{}};
    FloorOptions options;
    options.corner = "nw";
    options.height = chou1986_camera_height;
    const auto session = calibrate_floor_from(site, camera, picture, options);
    ASSERT_TRUE(session) << session.error().message;
    EXPECT_LT((session->calibration.map_from_camera.pose.translation() - shot.map_from_camera.translation()).norm(), 0.02);
    EXPECT_LT(squared_distance(session->calibration, shot.map_from_camera), 27);
    options.height.reset();
    EXPECT_FALSE(calibrate_floor_from(site, camera, picture, options)) << "without the height only the direction is known";
}

TEST(FloorSession, SaysWhatIsWrong) {
    const SiteCamera camera{"hall", "", make_camera_model(640, 480, 520, 520, 320, 240), KnownPose{}};
    LumaImage small(320, 240);
    const auto wrong_size = calibrate_floor_from(lab(), camera, small, {});
    ASSERT_FALSE(wrong_size);
    EXPECT_NE(wrong_size.error().message.find("320 x 240"), std::string::npos);
    FloorOptions no_size;
    no_size.tile = {{100, 300}, {200, 300}, {190, 250}, {110, 250}};
    no_size.grid.size = 0;
    LumaImage picture(640, 480);
    const auto tile = calibrate_floor_from(lab(), camera, picture, no_size);
    ASSERT_FALSE(tile);
    EXPECT_NE(tile.error().message.find("needs a size"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
