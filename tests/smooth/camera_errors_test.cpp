#include "roomfix/smooth/camera_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/evaluate/hall.hpp"

namespace roomfix {
namespace {

/// A hall whose east camera is exact and whose west camera has errors that are known here; `robots` drive on circles and both cameras see
/// them.
class TwoCameras {
public:
    explicit TwoCameras(std::size_t robots) {
        HallSenses senses;
        senses.cameras = true;
        site_ = hall_site(senses);
        std::get<KnownPose>(site_.cameras[1].placement).map_from_camera.covariance.setZero();
        site_.robots[0].odometry.reset();
        site_.robots[0].receivers.clear();
        for (std::size_t r = 1; r < robots; ++r) {
            site_.robots.push_back(site_.robots[0]);
            site_.robots[r].id = "r" + std::to_string(r + 1);
        }
    }

    std::vector<SixErrors> learned(const Vector6d& truth) {
        Tracker tracker(site_, {});
        tracker.keep_history();
        Random random(4);
        std::vector<Fix> fixes;
        for (int i = 0; i < 300; ++i) {
            const double t = 0.1 * i;
            for (int c = 0; c < 2; ++c) see(c, t + 0.03 * c, truth, random, tracker);
            const auto now = tracker.fixes(from_seconds(t + 0.05));
            fixes.insert(fixes.end(), now.begin(), now.end());
        }
        return camera_errors_of(tracker, fixes);
    }

private:
    void see(int c, double t, const Vector6d& truth, Random& random, Tracker& tracker) {
        const SiteCamera& camera = site_.cameras[static_cast<std::size_t>(c)];
        const View view = *fixed_view(camera);
        std::vector<PoseObservation> seen;
        for (std::size_t r = 0; r < site_.robots.size(); ++r) {
            const double turned = 0.3 * t + 2.0 * static_cast<double>(r);
            const Pose2 at{4 + 1.5 * std::cos(turned), 3 + 1.5 * std::sin(turned), turned + std::numbers::pi / 2};
            const auto floor = pixel_to_plane(view, *project_map_point(view, {at.x, at.y, 0}), 0);
            PoseObservation o;
            o.robot = static_cast<int>(r);
            o.by_calibration.topRows<2>() = *plane_point_by_calibration(view, *floor, 0);
            o.by_calibration.row(2) = -view.calibration.row(5);
            const double sigma = 0.005;
            Eigen::Vector3d error = sigma * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
            if (c == 0) error += o.by_calibration * truth;
            o.pose = {at.x + error.x(), at.y + error.y(), wrap_angle(at.yaw + error.z())};
            o.covariance = sigma * sigma * Eigen::Matrix3d::Identity() + o.by_calibration * o.by_calibration.transpose();
            seen.push_back(o);
        }
        tracker.observe(from_seconds(t), camera.id, seen);
    }

    Site site_;
};

TEST(CameraErrors, AreFoundBesideACameraThatIsExact) {
    Vector6d truth;
    truth << 1.2, -0.8, 0.3, 1.5, -1.1, 0.6;
    const auto found = TwoCameras(1).learned(truth);
    ASSERT_EQ(found.size(), 1U) << "nothing is learned about an exact camera";
    const Vector6d error = found[0].mean - truth;
    EXPECT_GT(found[0].sightings.all, 250);
    EXPECT_LT(found[0].sightings.doubted, 10);
    EXPECT_LT(error.dot(found[0].covariance.inverse() * error), 22.5);  // once in a thousand
    EXPECT_LT(found[0].covariance.trace(), 2.5) << "of 6 before";
    const auto spread = symmetric_eigen(found[0].covariance);
    EXPECT_GT(spread.eigenvalues()[0], 0);
    EXPECT_LT(spread.eigenvalues()[5], 1 + 1e-9) << "nothing is known less than before";
}

TEST(CameraErrors, ACameraThatWasMovedContradictsTheOther) {
    Vector6d moved = Vector6d::Zero();
    moved[5] = 100;
    const auto found = TwoCameras(1).learned(moved);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_GT(found[0].sightings.doubted, found[0].sightings.all / 3);
}

TEST(CameraErrors, WhatTwoRobotsTellIsAddedUp) {
    const Vector6d truth = Vector6d::Constant(0.5);
    const auto one = TwoCameras(1).learned(truth);
    const auto two = TwoCameras(2).learned(truth);
    ASSERT_EQ(one.size(), 1U);
    ASSERT_EQ(two.size(), 1U);
    EXPECT_GT(two[0].sightings.all, 1.8 * one[0].sightings.all) << "but for the moments until their wheels have told who is who";
    const Matrix6d more = two[0].covariance.inverse() - one[0].covariance.inverse();
    EXPECT_GT(symmetric_eigen(more).eigenvalues()[5], 5);
    EXPECT_LT(two[0].covariance.trace(), 0.9 * one[0].covariance.trace());
}

TEST(CameraErrors, NothingIsLearnedWithoutAHistoryOrFixes) {
    HallSenses senses;
    senses.cameras = true;
    Tracker tracker(hall_site(senses), {});
    EXPECT_TRUE(camera_errors_of(tracker, {}).empty());
    tracker.keep_history();
    EXPECT_TRUE(camera_errors_of(tracker, {}).empty());
}

}  // namespace
}  // namespace roomfix
