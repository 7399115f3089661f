#include "roomfix/corner/corner_locator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

/// A room of 5 x 4 m with four corners alike, a camera on a tripod or on a robot.
Site room(bool on_robot) {
    Site site;
    site.name = "room";
    site.walls = {{{0, 0}, {5, 0}, {5, 4}, {0, 4}, {0, 0}}};
    site.corners = {{"sw", {0, 0, 2.7}, 0}, {"se", {5, 0, 2.7}, radians(90)}, {"ne", {5, 4, 2.7}, radians(180)}, {"nw", {0, 4, 2.7}, radians(-90)}};
    site.robots = {{"r1", Cylinder{0.4, 0.5}}};
    site.robots[0].receivers = {Receiver{{0, 0, 0.5}, "", 0.02}};
    site.beacons = {{"b1", {1, 0.2, 2.4}, ""}, {"b2", {4.8, 3, 2.4}, ""}};
    SiteCamera camera{"eye", "frames", make_camera_model(640, 480, 600, 600, 319.5, 239.5), KnownHeight{0.7, 0.01, "r1"}, ""};
    if (on_robot) {
        UncertainPose3 mount{looking_at({0.1, 0, 0.7}, {1.1, 0, 1.2}), Matrix6d::Zero()};
        mount.covariance.diagonal() << 1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6;
        camera.placement = Mount{"r1", mount, true};
    }
    site.cameras = {camera};
    return site;
}

/// What an ideal camera would see of a corner, with errors of known covariance.
CornerObservation observed(const Eigen::Isometry3d& map_from_camera, const SiteCorner& corner, Random& random) {
    const Eigen::Matrix3d corner_from_map = Eigen::AngleAxisd(-corner.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Vector3d from_corner = corner_from_map * (map_from_camera.translation() - corner.position);
    CornerObservation seen;
    const double turn = 3e-4, shift = 8e-4;
    seen.view.corner_from_camera =
        exponential_rotation({random.normal(turn), random.normal(turn), random.normal(turn)}) * corner_from_map * map_from_camera.linear();
    seen.view.place = from_corner.head<2>() / -from_corner.z() + Eigen::Vector2d(random.normal(shift), random.normal(shift));
    seen.covariance = (Vector5d() << turn * turn, turn * turn, turn * turn, shift * shift, shift * shift).finished().asDiagonal();
    return seen;
}

TEST(CornerLocator, FourCornersAlikeAreFourHypotheses) {
    const Site site = room(false);
    const auto locator = CornerLocator::for_camera(site, site.cameras[0]);
    ASSERT_TRUE(locator);
    Random random(1);
    const Eigen::Isometry3d truth = looking_at({1.8, 1.5, 0.7}, {0, 0, 2.7});
    const CornerObservation seen = observed(truth, site.corners[0], random);
    LocatedCamera located;
    locator->locate({&seen, 1}, {}, located);
    ASSERT_EQ(located.places.size(), 4u);
    for (const CameraPlace& place : located.places) EXPECT_NEAR(place.weight, 0.25, 1e-9);

    CameraHints hints;
    hints.corner = 0;
    locator->locate({&seen, 1}, hints, located);
    ASSERT_EQ(located.places.size(), 1u);
    EXPECT_LT((located.places[0].map_from_camera.pose.translation() - truth.translation()).norm(), 0.03);
    const double looks = std::atan2(truth.linear()(1, 2), truth.linear()(0, 2));
    EXPECT_NEAR(located.places[0].pose.yaw, looks, 0.003);

    hints = {};
    hints.heading = CameraHints::Heading{looks + 0.1, 0.2};
    locator->locate({&seen, 1}, hints, located);
    EXPECT_EQ(located.places[0].corner, 0);
    EXPECT_GT(located.places[0].weight, 0.95);

    hints = {};
    hints.prediction = CameraHints::Prediction{{1.9, 1.4, looks}, (Eigen::Vector3d(0.04, 0.04, 0.01)).asDiagonal()};
    locator->locate({&seen, 1}, hints, located);
    EXPECT_EQ(located.places[0].corner, 0);
    EXPECT_GT(located.places[0].weight, 0.95);

    std::vector<RangeObservation> ranges;
    for (int b = 0; b < 2; ++b) {
        const Eigen::Vector3d ear(located.places[0].pose.x, located.places[0].pose.y, 0.5);
        ranges.push_back({0, 0, b, (site.beacons[static_cast<std::size_t>(b)].position - ear).norm() + 0.01, 0.02});
    }
    hints = {};
    hints.ranges = ranges;
    locator->locate({&seen, 1}, hints, located);
    EXPECT_EQ(located.places[0].corner, 0);
    EXPECT_GT(located.places[0].weight, 0.95);
}

TEST(CornerLocator, TheCamerasHeightIsASoftConstraint) {
    Random random(2);
    double nees = 0;
    const int count = 300;
    for (int i = 0; i < count; ++i) {
        Site site = room(false);
        site.corners[0].sigma = 0.004;
        const auto locator = CornerLocator::for_camera(site, site.cameras[0]);
        SiteCorner real = site.corners[0];  // the ceiling and the tripod are not quite where the file says
        for (int k = 0; k < 3; ++k) real.position[k] += random.normal(0.004);
        const Eigen::Isometry3d truth = looking_at({random.uniform(1, 3), random.uniform(1, 3), 0.7 + random.normal(0.01)}, {0.2, 0.1, 2.6});
        const CornerObservation seen = observed(truth, real, random);
        LocatedCamera located;
        CameraHints hints;
        hints.corner = 0;
        locator->locate({&seen, 1}, hints, located);
        ASSERT_EQ(located.places.size(), 1u);
        const UncertainPose3& found = located.places[0].map_from_camera;
        Vector6d error;
        error.head<3>() = truth.translation() - found.pose.translation();
        const Eigen::AngleAxisd turn(Eigen::Matrix3d(truth.linear() * found.pose.linear().transpose()));
        error.tail<3>() = turn.angle() * turn.axis();
        nees += error.dot(found.covariance.ldlt().solve(error)) / count;
    }
    // Mean of 300 chi-squares of 6: 5.34 to 6.69 but for one run in 1000.
    EXPECT_GT(nees, 5.3);
    EXPECT_LT(nees, 6.8);
}

TEST(CornerLocator, OnARobotTheMountTakesPartAndTheCovarianceIsTrue) {
    Site site = room(true);
    site.corners[0].sigma = 0;
    const auto locator = CornerLocator::for_camera(site, site.cameras[0]);
    ASSERT_TRUE(locator);
    const Mount& mount = std::get<Mount>(site.cameras[0].placement);
    Random random(3);
    double nees = 0;
    const int count = 300;
    for (int i = 0; i < count; ++i) {
        const Pose2 truth{random.uniform(1.5, 3), random.uniform(1.5, 2.5), radians(random.uniform(200, 240))};
        Vector6d off;
        for (int k = 0; k < 6; ++k) off[k] = random.normal(1e-3);
        const Eigen::Isometry3d real_mount = perturbed(mount.robot_from_camera.pose, off);
        const CornerObservation seen = observed(map_from_robot(truth) * real_mount, {"sw", {0, 0, 2.7}, 0}, random);
        CameraHints hints;
        hints.corner = 0;
        LocatedCamera located;
        locator->locate({&seen, 1}, hints, located);
        ASSERT_EQ(located.places.size(), 1u);
        const CameraPlace& place = located.places[0];
        const Eigen::Vector3d error(truth.x - place.pose.x, truth.y - place.pose.y, wrap_angle(truth.yaw - place.pose.yaw));
        nees += error.dot(place.covariance.ldlt().solve(error)) / count;
    }
    // Mean of 300 chi-squares of 3: 2.55 to 3.49 but for one run in 1000.
    EXPECT_GT(nees, 2.5);
    EXPECT_LT(nees, 3.5);
}

TEST(CornerLocator, ACameraThatWouldStandBehindAWallIsNone) {
    Site site = room(false);
    site.corners = {site.corners[0]};
    site.walls.push_back({{0.5, -1}, {0.5, 5}});  // a partition in front of the corner
    const auto locator = CornerLocator::for_camera(site, site.cameras[0]);
    Random random(4);
    const CornerObservation seen = observed(looking_at({2, 2, 0.7}, {0, 0, 2.7}), site.corners[0], random);
    LocatedCamera located;
    locator->locate({&seen, 1}, {}, located);
    EXPECT_TRUE(located.places.empty());
    EXPECT_NE(located.reason.find("behind a wall"), std::string::npos);
}

TEST(CornerLocator, ACameraAboveTheCeilingAndASiteWithoutCornersAreErrors) {
    Site site = room(false);
    std::get<KnownHeight>(site.cameras[0].placement).height = 2.7;
    EXPECT_FALSE(CornerLocator::for_camera(site, site.cameras[0]));
    site = room(false);
    site.corners.clear();
    EXPECT_FALSE(CornerLocator::for_camera(site, site.cameras[0]));
    site = room(false);
    site.cameras[0].placement = KnownPose{};
    EXPECT_FALSE(CornerLocator::for_camera(site, site.cameras[0]));
}

TEST(CornerLocator, TwoCornersInOnePictureSpeakForTheSamePlace) {
    const Site site = room(true);
    const auto locator = CornerLocator::for_camera(site, site.cameras[0]);
    Random random(6);
    const Pose2 truth{3.2, 2.1, radians(180)};
    const Eigen::Isometry3d camera = map_from_robot(truth) * std::get<Mount>(site.cameras[0].placement).robot_from_camera.pose;
    std::vector<CornerObservation> seen = {observed(camera, site.corners[0], random), observed(camera, site.corners[3], random)};
    for (auto& s : seen) s.weight = 0.5;
    CameraHints hints;
    hints.prediction = CameraHints::Prediction{truth, Eigen::Vector3d(0.01, 0.01, 0.001).asDiagonal()};
    LocatedCamera located;
    locator->locate(seen, hints, located);
    ASSERT_FALSE(located.places.empty());
    EXPECT_GT(located.places[0].weight, 0.95);
    EXPECT_NEAR(located.places[0].pose.x, truth.x, 0.03);
}

TEST(CornerLocator, AnotherWallAngleIsAnotherCorner) {
    Site site = room(false);
    site.corners[1].wall_angle = radians(120);
    const auto locator = CornerLocator::for_camera(site, site.cameras[0]);
    ASSERT_EQ(locator->wall_angles().size(), 2u);
    Random random(5);
    CornerObservation seen = observed(looking_at({1.8, 1.5, 0.7}, {0, 0, 2.7}), site.corners[0], random);
    LocatedCamera located;
    locator->locate({&seen, 1}, {}, located);
    EXPECT_EQ(located.places.size(), 3u);
}

/// Both corners of a moulding as one picture shows them: the lower one, where the walls' edge ends, and the upper one.
std::vector<CornerObservation> both_corners(const Eigen::Isometry3d& map_from_camera, SiteCorner corner, double moulding, Random& random) {
    const double distance = corner.position.z() - map_from_camera.translation().z();
    CornerObservation upper = observed(map_from_camera, corner, random);
    corner.position.z() -= moulding;
    CornerObservation lower = observed(map_from_camera, corner, random);
    lower.part = MouldingEdge::lower;
    lower.other_rise = moulding / (distance - moulding);
    upper.part = MouldingEdge::upper;
    upper.other_rise = -moulding / distance;
    lower.other_rise_sigma = upper.other_rise_sigma = 0.003;
    lower.weight = 0.6;
    upper.weight = 0.4;
    return {lower, upper};
}

TEST(CornerLocator, BothCornersOfAStatedMouldingAreOneSharpPlace) {
    Site site = room(false);
    site.corners[0].moulding = 0.08;
    const auto locator = CornerLocator::for_camera(site, site.cameras[0]);
    ASSERT_TRUE(locator);
    Random random(7);
    const Eigen::Isometry3d truth = looking_at({1.8, 1.5, 0.7}, {0, 0, 2.7});
    const auto seen = both_corners(truth, site.corners[0], 0.08, random);
    CameraHints hints;
    hints.corner = 0;
    LocatedCamera located;
    locator->locate(seen, hints, located);
    ASSERT_EQ(located.places.size(), 1u);
    EXPECT_LT(std::hypot(located.places[0].pose.x - 1.8, located.places[0].pose.y - 1.5), 0.03);
    EXPECT_LT(std::sqrt(located.places[0].covariance.topLeftCorner<2, 2>().trace()), 0.02);
}

TEST(CornerLocator, OfAMouldingThatIsNotStatedEitherCornerMayHaveBeenMeasured) {
    const Site site = room(false);
    const auto locator = CornerLocator::for_camera(site, site.cameras[0]);
    ASSERT_TRUE(locator);
    Random random(8);
    const Eigen::Isometry3d truth = looking_at({1.8, 1.5, 0.7}, {0, 0, 2.7});
    const auto seen = both_corners(truth, site.corners[0], 0.08, random);
    CameraHints hints;
    hints.corner = 0;
    LocatedCamera located;
    locator->locate(seen, hints, located);
    ASSERT_EQ(located.places.size(), 2u);
    EXPECT_NEAR(located.places[0].weight, 0.6, 1e-9);
    EXPECT_NEAR(located.best_corner, 1, 1e-9);
    const auto place_of = [](const CameraPlace& p) { return Eigen::Vector2d(p.pose.x, p.pose.y); };
    EXPECT_LT((place_of(located.places[1]) - Eigen::Vector2d(1.8, 1.5)).norm(), 0.03) << "the site's corner is at the ceiling, where the upper one was seen";
    const Eigen::Vector2d apart = place_of(located.places[0]) - place_of(located.places[1]);
    EXPECT_NEAR(apart.norm(), std::hypot(1.8, 1.5) * 0.08 / 1.92, 0.02);
    EXPECT_LT(apart.dot(located.places[0].covariance.topLeftCorner<2, 2>().ldlt().solve(apart)), 3);

    // A prediction tells them apart.
    const double looks = std::atan2(truth.linear()(1, 2), truth.linear()(0, 2));
    hints.prediction = CameraHints::Prediction{{1.8, 1.5, looks}, (Eigen::Vector3d(1e-4, 1e-4, 1e-4)).asDiagonal()};
    locator->locate(seen, hints, located);
    EXPECT_GT(located.places[0].weight, 0.95);
    EXPECT_LT((place_of(located.places[0]) - Eigen::Vector2d(1.8, 1.5)).norm(), 0.03);
}

TEST(CornerLocator, WhereAStatedMouldingIsNotSeenItsEdgesMayBeEither) {
    Site site = room(false);
    site.corners[0].moulding = 0.08;
    const auto locator = CornerLocator::for_camera(site, site.cameras[0]);
    ASSERT_TRUE(locator);
    Random random(9);
    const Eigen::Isometry3d truth = looking_at({1.8, 1.5, 0.7}, {0, 0, 2.7});
    SiteCorner lower = site.corners[0];
    lower.position.z() -= 0.08;
    const CornerObservation seen = observed(truth, lower, random);
    CameraHints hints;
    hints.corner = 0;
    LocatedCamera located;
    locator->locate({&seen, 1}, hints, located);
    ASSERT_FALSE(located.places.empty());
    EXPECT_LT(std::hypot(located.places[0].pose.x - 1.8, located.places[0].pose.y - 1.5), 0.03);
    EXPECT_GT(std::sqrt(located.places[0].covariance.topLeftCorner<2, 2>().trace()), 0.03) << "80 % of them are the lower ones";
}

}  // namespace
}  // namespace roomfix
