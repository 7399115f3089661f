#include "roomfix/pipeline/site_calibration.hpp"

#include <gtest/gtest.h>

#include "roomfix/evaluate/hall.hpp"
#include "roomfix/site/load_site.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

Site hall() {
    HallSenses senses;
    senses.cameras = senses.ceiling = true;
    Site site = hall_site(senses);
    for (SiteCamera& camera : site.cameras) camera.source = "frames/" + camera.id;
    return site;
}

/// All six errors one standard deviation off, and known four times better than before.
SixErrors learned_of(TrackingModels& models, const std::string& camera) {
    SixErrors six;
    six.source = models.source(camera);
    six.sightings = {100, 3};
    six.mean.setOnes();
    six.covariance *= 1.0 / 16;
    return six;
}

TEST(SiteCalibration, MovesACameraOnTheWallAndOneOnARobot) {
    TrackingModels models(hall(), {});
    const auto found = calibrated_cameras(models, {learned_of(models, "west"), learned_of(models, "up")});
    ASSERT_EQ(found.size(), 2U);
    for (const SiteCalibration& camera : found) {
        EXPECT_NEAR(camera.error_now, camera.error_before / 4, 0.01 * camera.error_before);
        EXPECT_EQ(camera.sightings.all, 100);
        EXPECT_GE(camera.surprise, 1);
        EXPECT_LE(camera.surprise, 2.6) << "six errors of one standard deviation";
    }
    const UncertainPose3& west = std::get<KnownPose>(found[0].camera.placement).map_from_camera;
    const UncertainPose3& before = std::get<KnownPose>(models.site.camera("west")->placement).map_from_camera;
    EXPECT_LT((error_between(before.pose, west.pose) - found[0].moved).norm(), 1e-9);
    EXPECT_LT((west.covariance - before.covariance / 16).norm(), 1e-12);
    EXPECT_TRUE(std::get<Mount>(found[1].camera.placement).has_covariance);
}

TEST(SiteCalibration, WhatIsLearnedOfALensStaysTiedToThePose) {
    Site site = hall();
    SiteCamera& west = site.cameras[0];
    west.intrinsics_covariance.diagonal().head<4>().setConstant(4);  // px^2
    std::get<KnownPose>(west.placement).by_intrinsics(2, 0) = 0.002;
    TrackingModels models(site, {});
    const auto found = calibrated_cameras(models, {learned_of(models, "west")});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_GT((found[0].camera.model.intrinsics() - west.model.intrinsics()).norm(), 0.1) << "px";
    EXPECT_LT(found[0].camera.intrinsics_covariance.trace(), west.intrinsics_covariance.trace());
    EXPECT_LT(found[0].error_now, 0.35 * found[0].error_before);
    // Into a site file and back.
    site.cameras[0] = found[0].camera;
    const LoadedSite read = parse_site(site_text(site), ".");
    ASSERT_TRUE(read.usable()) << (read.problems.empty() ? "" : read.problems[0].message);
    const View again = *fixed_view(read.site.cameras[0]), now = *fixed_view(found[0].camera);
    EXPECT_LT((again.map_from_camera.covariance - now.map_from_camera.covariance).norm(), 1e-9);
}

TEST(SiteCalibration, APoseTypedInByHandStaysExactWhereOnlyTheLensIsLearned) {
    Site site = hall();
    SiteCamera& west = site.cameras[0];
    auto& known = std::get<KnownPose>(west.placement);
    known.map_from_camera.covariance.setZero();
    known.has_covariance = false;
    west.intrinsics_covariance.diagonal().head<4>().setConstant(4);
    TrackingModels models(site, {});
    const auto found = calibrated_cameras(models, {learned_of(models, "west")});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_FALSE(std::get<KnownPose>(found[0].camera.placement).has_covariance);
    EXPECT_EQ(found[0].moved.norm(), 0);
    site.cameras[0] = found[0].camera;
    EXPECT_TRUE(parse_site(site_text(site), ".").usable());
}

}  // namespace
}  // namespace roomfix
