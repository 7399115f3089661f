#include "roomfix/smooth/terms.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/random.hpp"
#include "roomfix/corner/corner_geometry.hpp"
#include "roomfix/evaluate/hall.hpp"

namespace roomfix {
namespace {

/// A site with all kinds of sources, a trajectory through it, and one observation of each kind.
class Terms : public testing::Test {
protected:
    Terms() : models_(hall(), {}) {
        for (int i = 0; i < 3; ++i) {
            way_.times.push_back(from_seconds(0.08 * i));
            Knot knot;
            knot << 3.0 + 0.04 * i, 2.5 + 0.01 * i, 0.4 + 0.05 * i, 0.5, 0.12, 0.6;
            way_.knots.push_back(knot);
        }
    }
    static Site hall() {
        Site site = hall_site({true, true, true, true, true});
        site.robots[0].receivers[0].bias_sigma = 0.05;
        site.robots[0].receivers[0].scale_sigma = 0.01;
        return site;
    }
    Pose2 pose() const {
        const Knot at = way_.at(time_);
        return {at[0], at[1], at[2]};
    }
    /// Derivatives against differences, at the trajectory and small slow errors, in which the models are linear.
    void check(const Measured& measured) {
        const MeasuredTerm term = measured_term(measured, 0, way_, models_);
        ASSERT_TRUE(term.cost);
        ASSERT_FALSE(term.slow.empty() && term.dimensions > 1);
        Random random(5);
        std::vector<std::vector<double>> values = {{}, {}};
        for (int end = 0; end < 2; ++end)
            values[static_cast<std::size_t>(end)].assign(way_.knots[static_cast<std::size_t>(end)].data(),
                                                         way_.knots[static_cast<std::size_t>(end)].data() + 6);
        for (const SlowState& state : term.slow) values.push_back({0.01 * std::sqrt(state.variance) * random.normal()});
        std::vector<const double*> pointers;
        for (const auto& v : values) pointers.push_back(v.data());
        const int rows = term.cost->num_residuals();
        std::vector<std::vector<double>> jacobians;
        std::vector<double*> out;
        for (const auto& v : values) jacobians.emplace_back(v.size() * static_cast<std::size_t>(rows));
        for (auto& j : jacobians) out.push_back(j.data());
        std::vector<double> residual(static_cast<std::size_t>(rows)), plus = residual, minus = residual;
        ASSERT_TRUE(term.cost->Evaluate(pointers.data(), residual.data(), out.data()));
        for (std::size_t b = 0; b < values.size(); ++b) {
            for (std::size_t i = 0; i < values[b].size(); ++i) {
                const double step = 1e-6;
                const double before = values[b][i];
                values[b][i] = before + step;
                ASSERT_TRUE(term.cost->Evaluate(pointers.data(), plus.data(), nullptr));
                values[b][i] = before - step;
                ASSERT_TRUE(term.cost->Evaluate(pointers.data(), minus.data(), nullptr));
                values[b][i] = before;
                for (std::size_t r = 0; r < residual.size(); ++r) {
                    const double slope = (plus[r] - minus[r]) / (2 * step);
                    EXPECT_NEAR(jacobians[b][r * values[b].size() + i], slope, 5e-3 * (1 + std::abs(slope))) << "block " << b << " value " << i << " row " << r;
                }
            }
        }
    }

    TrackingModels models_;
    Trajectory way_;
    Nanoseconds time_ = from_seconds(0.05);
};

TEST_F(Terms, PosesHaveTheirDerivatives) {
    PoseObservation seen;
    seen.pose = {pose().x + 0.01, pose().y - 0.02, pose().yaw + 0.03};
    seen.by_calibration.setRandom();
    seen.covariance = 1e-4 * Eigen::Matrix3d::Identity() + seen.by_calibration * seen.by_calibration.transpose();
    check({time_, models_.source("west"), seen});
    seen.yaw_known = false;
    check({time_, models_.source("west"), seen});
}

TEST_F(Terms, LandmarksHaveTheirDerivatives) {
    const int source = models_.source("up");
    for (std::size_t i = 0; i < models_.site.landmarks.size(); ++i) {
        LandmarkObservation seen;
        for (const Eigen::Vector3d& point : models_.landmark_points[i]) {
            const auto pixel = predict_point(models_.onboard.at(source).camera, pose(), point);
            if (!pixel || !models_.onboard.at(source).camera.model.contains(*pixel, 4)) break;
            seen.points.push_back({*pixel + Eigen::Vector2d(0.1, -0.05), 0.01 * Eigen::Matrix2d::Identity()});
        }
        if (seen.points.size() == 3) return check({time_, source, SeenLandmark{seen, static_cast<int>(i)}});
    }
    FAIL() << "no landmark in sight";
}

TEST_F(Terms, CornersHaveTheirDerivatives) {
    const int source = models_.source("eye");
    const Eigen::Isometry3d map_from_camera = map_from_robot(pose()) * models_.onboard.at(source).camera.robot_from_camera.pose;
    const SiteCorner& corner = models_.site.corners[2];
    const Eigen::Matrix3d corner_from_map = Eigen::AngleAxisd(-corner.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Vector3d at = corner_from_map * (map_from_camera.translation() - corner.position);
    CornerObservation seen;
    seen.view.corner_from_camera = corner_from_map * map_from_camera.linear();
    seen.view.place = at.head<2>() / -at.z();
    seen.covariance = 1e-5 * Matrix5d::Identity();
    check({time_, source, SeenCorner{seen, 2}});
}

TEST_F(Terms, RangesHaveTheirDerivativesOnTimeLateAndEarly) {
    const PredictedRange exact = predict_range(pose(), models_.receiver(0).receiver, models_.site.beacons[1].position);
    for (const double error : {0.0, 0.02, -0.05, 0.3, 2.0, -0.5}) {
        RangeObservation range;
        range.beacon = 1;
        range.range = exact.range + error;
        range.sigma = 0.03;
        check({time_, models_.range_source, range});
    }
    RangeDifferenceObservation difference;
    difference.beacons = {0, 3};
    const PredictedRange a = predict_range(pose(), models_.receiver(0).receiver, models_.site.beacons[0].position);
    const PredictedRange b = predict_range(pose(), models_.receiver(0).receiver, models_.site.beacons[3].position);
    difference.difference = b.range - a.range + 0.04;
    difference.sigma = 0.03;
    check({time_, models_.range_source, difference});
}

TEST_F(Terms, LandmarksBehindTheCameraAreNoTerm) {
    LandmarkObservation seen;
    for (int i = 0; i < 3; ++i) seen.points.push_back({Eigen::Vector2d(100 + 10 * i, 100), Eigen::Matrix2d::Identity()});
    way_.knots[0][0] = way_.knots[1][0] = 1e7;
    models_.landmark_points[0] = {{0, 0, -5}, {0.1, 0, -5}, {0, 0.1, -5}};
    EXPECT_FALSE(measured_term({time_, models_.source("up"), SeenLandmark{seen, 0}}, 0, way_, models_).cost);
}

TEST(OutlierLoss, IsSmoothAndEndsFlat) {
    for (const double least : {0.0, 1e-3}) {
        const OutlierLoss loss(9, least);
        for (const double s : {0.0, 1.0, 8.9, 9.0, 9.1, 30.0, 500.0, 1e5}) {
            double at[3], after[3], before[3];
            loss.Evaluate(s, at);
            const double step = 1e-4;
            loss.Evaluate(s + step, after);
            loss.Evaluate(std::max(s - step, 0.0), before);
            const double width = s + step - std::max(s - step, 0.0);
            EXPECT_NEAR(at[1], (after[0] - before[0]) / width, 1e-4 + 1e-9 * s);
            EXPECT_NEAR(at[2], (after[1] - before[1]) / width, 1e-4);
        }
        double zero[3];
        loss.Evaluate(0, zero);
        EXPECT_NEAR(zero[0], 0, 1e-12);
        EXPECT_NEAR(zero[1], 1 + least, 0.02);
    }
}

}  // namespace
}  // namespace roomfix
