#include <gtest/gtest.h>

#include <numbers>

#include "count_allocations.hpp"
#include "roomfix/base/decompositions.hpp"
#include "roomfix/ceiling/ceiling_observer.hpp"
#include "roomfix/ceiling/kim2011.hpp"
#include "roomfix/ceiling/robot_locator.hpp"
#include "roomfix/imaging/tag_detector.hpp"
#include "roomfix/simulate/scenario.hpp"
#include "roomfix/simulate/tag_scene.hpp"

namespace roomfix {
namespace {

/// The kim2011 room without its lamp, with a frame of any scene from any pose.
class Ceiling : public ::testing::Test {
protected:
    Ceiling() : scenario(kim2011_scenario(41)), up(scenario.up_cameras[0]), renderer(up.truth.model, up.sensor, up.glare, 41) {
        scenario.ceiling.patches.erase(scenario.ceiling.patches.begin());
        camera = {scenario.site.cameras[0].model, std::get<Mount>(scenario.site.cameras[0].placement).robot_from_camera};
    }
    LumaImage frame_at(const Pose2& pose) {
        LumaImage frame;
        renderer.render(scenario.ceiling, map_from_robot(pose) * up.truth.robot_from_camera.pose, 1, ++taken, frame);
        return frame;
    }
    LocatedRobot locate(const Pose2& pose, const std::vector<RangeObservation>& ranges = {}, const LocatorHints& hints = {}) {
        CeilingObserver observer(camera, true, scenario.site.landmarks);
        observer.observe(frame_at(pose), seen);
        RobotLocator locator(scenario.site, 0, camera);
        LocatedRobot located;
        locator.locate(seen.landmarks, ranges, hints, located);
        return located;
    }
    std::vector<RangeObservation> ranges_at(const Pose2& pose) const {
        std::vector<RangeObservation> ranges;
        const Eigen::Vector3d ear = map_from_robot(pose) * scenario.site.robots[0].receiver()->position;
        for (std::size_t b = 0; b < scenario.site.beacons.size(); ++b) {
            ranges.push_back({0, 0, static_cast<int>(b), (scenario.site.beacons[b].position - ear).norm(), 0.015});
        }
        return ranges;
    }
    /// Another landmark of the same shape, in the site and on the ceiling.
    void add_landmark_at(const Eigen::Vector2d& place, double yaw) {
        SiteLandmark landmark{"n" + std::to_string(scenario.site.landmarks.size() + 1), LedTriangle{0.10, 0.15}};
        landmark.map_from_landmark = Eigen::Translation3d(place.x(), place.y(), 3) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
        landmark.sigma = 0;
        scenario.site.landmarks.push_back(landmark);
        add_landmark(landmark, {}, scenario.ceiling);
    }
    static void expect_at(const LocatedRobot& located, const Pose2& truth) {
        ASSERT_FALSE(located.places.empty()) << located.reason;
        EXPECT_LT(std::hypot(located.places[0].pose.x - truth.x, located.places[0].pose.y - truth.y), 0.006);
        EXPECT_LT(std::abs(wrap_angle(located.places[0].pose.yaw - truth.yaw)), radians(0.3));
    }

    Scenario scenario;
    const ScenarioUpCamera& up;
    CeilingRenderer renderer;
    CameraOnRobot camera;
    CeilingResult seen;
    std::uint64_t taken = 0;
};

TEST_F(Ceiling, OneLandmarkGivesTheWholePose) {
    for (const double yaw : {-3.0, -1.2, 0.0, 0.4, 2.2}) expect_at(locate({0.7, 1.5, yaw}), {0.7, 1.5, yaw});
    EXPECT_TRUE(locate({1.0, 1.25, 0.3}).places[0].yaw_known) << "right below the landmark, too";
}

TEST_F(Ceiling, RangesAloneGiveAPlaceWithoutHeading) {
    scenario.ceiling.discs.clear();
    const Pose2 truth{0.5, 1.0, 1.0};
    const std::vector<Eigen::Vector2d> start = {{0.9, 1.4}};
    LocatorHints hints;
    hints.places = start;
    const LocatedRobot located = locate(truth, ranges_at(truth), hints);
    ASSERT_FALSE(located.places.empty()) << located.reason;
    EXPECT_LT(std::hypot(located.places[0].pose.x - truth.x, located.places[0].pose.y - truth.y), 0.01);
    EXPECT_FALSE(located.places[0].yaw_known);
    EXPECT_GT(located.places[0].covariance(2, 2), 1);
}

TEST_F(Ceiling, TwoLandmarksOfTheSameShapeAreToldApartByWhereTheyAreToEachOther) {
    add_landmark_at({1.6, 1.0}, 0.5);
    const Pose2 truth{1.2, 1.2, 0.8};
    const LocatedRobot located = locate(truth);
    EXPECT_EQ(seen.landmarks.size(), 2U);
    expect_at(located, truth);
    EXPECT_EQ(located.places[0].landmarks.size(), 2U);
    EXPECT_GT(located.places[0].weight, 0.99);
}

TEST_F(Ceiling, WhichOfManyLandmarks) {
    add_landmark_at({5.0, 1.25}, 0);
    add_landmark_at({1.0, 4.4}, radians(90));
    const Pose2 truth{0.8, 1.1, 0.3};
    const LocatedRobot open = locate(truth);
    ASSERT_EQ(open.places.size(), 3U) << "all that look alike are kept";
    EXPECT_NEAR(open.places[0].weight, 1.0 / 3, 1e-6);
    expect_at(locate(truth, ranges_at(truth)), truth);
    EXPECT_EQ(locate(truth, ranges_at(truth)).places.size(), 1U) << "the beacons heard say where";
    LocatorHints tracker;
    tracker.prediction = LocatorHints::Prediction{{0.9, 1.0, 0.2}, Eigen::Vector3d(0.04, 0.04, 0.1).asDiagonal()};
    EXPECT_EQ(locate(truth, {}, tracker).places.size(), 1U);
    LocatorHints told;
    told.landmark = 2;
    EXPECT_GT(locate(truth, {}, told).places[0].pose.y, 3) << "what the user says is believed";
}

TEST_F(Ceiling, DifferentLegsTellLandmarksApart) {
    SiteLandmark other{"wide", LedTriangle{0.10, 0.20}};
    other.map_from_landmark = Eigen::Translation3d(5.0, 1.25, 3) * Eigen::AngleAxisd(0, Eigen::Vector3d::UnitZ());
    scenario.site.landmarks.push_back(other);
    const LocatedRobot located = locate({0.8, 1.1, 0.3});
    expect_at(located, {0.8, 1.1, 0.3});
    EXPECT_EQ(located.places.size(), 1U);
}

TEST_F(Ceiling, ALedThatIsDeadOrOutsideIsSaidSo) {
    scenario.ceiling.discs.erase(scenario.ceiling.discs.begin() + 1);
    EXPECT_TRUE(locate({0.8, 1.1, 0.3}).places.empty());
    EXPECT_NE(seen.reason.find("is a LED dead or outside the picture?"), std::string::npos) << seen.reason;
    const Pose2 truth{0.8, 1.1, 0.3};
    const std::vector<Eigen::Vector2d> start = {{1.0, 1.0}};
    LocatorHints hints;
    hints.places = start;
    EXPECT_FALSE(locate(truth, ranges_at(truth), hints).places.empty()) << "the ranges still give a place";
}

TEST_F(Ceiling, APanelHalfOutOfThePictureGivesNoFixOrARightOne) {
    for (double x = 2.2; x < 2.7; x += 0.02) {
        const Pose2 truth{x, 1.25, std::numbers::pi / 2};
        const LocatedRobot located = locate(truth);
        if (!located.places.empty()) expect_at(located, truth);
    }
}

TEST_F(Ceiling, ATurnedMirrorImageIsNoLandmark) {
    // The same three LEDs with the legs exchanged: what a mirror in the ceiling would show.
    for (CeilingDisc& led : scenario.ceiling.discs) led.centre = Eigen::Vector2d(1.0, 1.25) + Eigen::Vector2d(1.25 - led.centre.y(), 1.0 - led.centre.x());
    EXPECT_TRUE(locate({0.8, 1.1, 0.3}).places.empty());
}

TEST_F(Ceiling, ADarkPictureHasNoSpot) {
    CeilingObserver observer(camera, true, scenario.site.landmarks);
    observer.observe(LumaImage(352, 288), seen);
    EXPECT_EQ(seen.reason, "no small bright spot in the picture");
}

TEST_F(Ceiling, NoAllocationInSteadyState) {
    if (!counts_allocations) GTEST_SKIP() << "not in a sanitized build";
    CeilingObserver observer(camera, true, scenario.site.landmarks);
    std::vector<LumaImage> frames;
    for (int i = 0; i < 4; ++i) frames.push_back(frame_at({0.7 + 0.1 * i, 1.1, 0.5 * i}));
    for (const LumaImage& frame : frames) observer.observe(frame, seen);
    const long before = allocations;
    for (const LumaImage& frame : frames) observer.observe(frame, seen);
    EXPECT_EQ(allocations - before, 0);
    EXPECT_EQ(seen.landmarks.size(), 1U);
}

TEST_F(Ceiling, DerivativesOfASeenPoint) {
    camera.robot_from_camera.pose = perturbed(camera.robot_from_camera.pose, (Vector6d() << 0.1, -0.05, 0, 0.03, -0.02, 0.4).finished());
    const Pose2 pose{0.7, 1.3, 0.6};
    const Eigen::Vector3d point(1.05, 1.2, 3.0);
    SeenPointJacobian j;
    const Eigen::Vector2d at = *predict_point(camera, pose, point, &j);
    constexpr double h = 1e-6;
    const auto close = [&](const Eigen::Vector2d& moved, const Eigen::Vector2d& slope) { EXPECT_LT(((moved - at) / h - slope).norm(), 1e-2); };
    close(*predict_point(camera, {pose.x + h, pose.y, pose.yaw}, point), j.by_pose.col(0));
    close(*predict_point(camera, {pose.x, pose.y + h, pose.yaw}, point), j.by_pose.col(1));
    close(*predict_point(camera, {pose.x, pose.y, pose.yaw + h}, point), j.by_pose.col(2));
    for (int i = 0; i < 6; ++i) {
        CameraOnRobot moved = camera;
        moved.robot_from_camera.pose = perturbed(camera.robot_from_camera.pose, h * Vector6d::Unit(i));
        close(*predict_point(moved, pose, point), j.by_mount.col(i));
    }
    for (int i = 0; i < 3; ++i) close(*predict_point(camera, pose, point + h * Eigen::Vector3d::Unit(i)), j.by_point.col(i));
}

TEST_F(Ceiling, TheMountsUncertaintyIsInTheFix) {
    const double level = locate({0.8, 1.1, 0.3}).places[0].covariance.topLeftCorner<2, 2>().trace();
    camera.robot_from_camera.covariance(3, 3) = camera.robot_from_camera.covariance(4, 4) = radians(0.5) * radians(0.5);
    const double tilted = locate({0.8, 1.1, 0.3}).places[0].covariance.topLeftCorner<2, 2>().trace();
    EXPECT_NEAR(std::sqrt(tilted - level), std::numbers::sqrt2 * 2.7 * radians(0.5), 0.005) << "half a degree is 2.4 cm at 2.7 m";
}

TEST_F(Ceiling, TagsOnCeilingAndWallGiveTheWholePose) {
    scenario.site.landmarks.clear();
    SiteLandmark above{"t7", Tag{7, 0.20}};
    above.map_from_landmark.linear() << 0, 1, 0, 1, 0, 0, 0, 0, -1;  // faces down, its upper edge towards +x
    above.map_from_landmark.translation() = Eigen::Vector3d(1.0, 1.25, 3.0);
    SiteLandmark wall{"t8", Tag{8, 0.30}};
    wall.map_from_landmark.linear() << 0, 0, -1, -1, 0, 0, 0, 1, 0;  // faces -x, on a wall ahead
    wall.map_from_landmark.translation() = Eigen::Vector3d(4.0, 1.2, 1.6);
    for (auto* landmark : {&above, &wall}) landmark->sigma = 0;
    // Mean normalised error squared of 3 unknowns over 60 looks: 3 +- 1.2 is a false alarm in some ten thousand.
    double sum = 0;
    Random random(12);
    CameraOnRobot ahead = camera;  // looks forward and a little up
    ahead.robot_from_camera.pose = looking_at({0, 0, 0.5}, {1, 0, 0.75});
    for (int i = 0; i < 60; ++i) {
        const bool up_there = i % 2 == 0;
        const SiteLandmark& landmark = up_there ? above : wall;
        const CameraOnRobot& eye = up_there ? camera : ahead;
        scenario.site.landmarks = {landmark};
        const Pose2 truth = up_there ? Pose2{random.uniform(0.7, 1.3), random.uniform(1.0, 1.5), random.uniform(-3, 3)}
                                     : Pose2{random.uniform(1.4, 2.2), random.uniform(0.9, 1.5), random.uniform(-0.2, 0.2)};
        LumaImage frame(352, 288);
        for (int y = 0; y < 288; ++y) std::memset(frame.row(y), 120, 352);
        paint_tag({eye.model, {map_from_robot(truth) * eye.robot_from_camera.pose, Matrix6d::Zero()}}, landmark.map_from_landmark, std::get<Tag>(landmark.kind),
                  1.5, static_cast<std::uint64_t>(i), frame);
        TagDetector detector;
        std::vector<SeenTag> tags;
        detector.detect(frame, tags);
        ASSERT_EQ(tags.size(), 1U) << i;
        LandmarkObservation observation;
        const double sigma = detector.settings().corner_sigma;
        for (const auto& corner : tags[0].corners) observation.points.push_back({corner, sigma * sigma * Eigen::Matrix2d::Identity()});
        observation.shapes.push_back(0);
        RobotLocator locator(scenario.site, 0, eye);
        LocatedRobot located;
        locator.locate({&observation, 1}, {}, {}, located);
        ASSERT_FALSE(located.places.empty()) << located.reason;
        const RobotPlace& place = located.places[0];
        const Eigen::Vector3d error(place.pose.x - truth.x, place.pose.y - truth.y, wrap_angle(place.pose.yaw - truth.yaw));
        EXPECT_LT(error.head<2>().norm(), 0.05);
        sum += error.dot(place.covariance.inverse() * error);
    }
    EXPECT_GT(sum / 60, 1.0);
    EXPECT_LT(sum / 60, 5.0);
}

TEST_F(Ceiling, ThePublishedMethodIsRightWhereItsAssumptionsHold) {
    Kim2011 published(scenario.site.landmarks[0], std::get<Mount>(scenario.site.cameras[0].placement));
    const Pose2 truth{0.8, 1.0, 0.7};
    const auto by_image = published.locate(frame_at(truth), std::nullopt, 2.7);
    ASSERT_TRUE(by_image);
    EXPECT_LT(std::hypot(by_image->pose.x - truth.x, by_image->pose.y - truth.y), 0.05);
    EXPECT_LT(std::abs(wrap_angle(by_image->pose.yaw - truth.yaw)), radians(3));
    EXPECT_FALSE(by_image->used_range);
    const double distance = (Eigen::Vector3d(1, 1.25, 3) - Eigen::Vector3d(truth.x, truth.y, 0.3)).norm();
    EXPECT_TRUE(published.locate(frame_at(truth), distance, 2.7)->used_range);
    EXPECT_FALSE(published.locate(frame_at(truth), distance + 0.3, 2.7)->used_range) << "Kim (7): a range that disagrees is not used";
    std::string reason;
    EXPECT_FALSE(published.locate(LumaImage(352, 288), distance, 2.7, &reason));
    EXPECT_FALSE(reason.empty());
}

}  // namespace
}  // namespace roomfix
