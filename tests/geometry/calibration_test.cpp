#include "roomfix/geometry/calibration.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

template <int N>
Eigen::Matrix<double, N, N> some_covariance(Random& random, double scale) {
    Eigen::Matrix<double, N, N> root;
    for (Eigen::Index i = 0; i < root.size(); ++i) root.data()[i] = scale * random.normal();
    return root * root.transpose();
}

/// A pose and five uncertain numbers of very different size; the others are exact.
struct Known {
    Matrix6d pose;
    IntrinsicsErrors intrinsics;
    CalibrationRoot root;

    explicit Known(Random& random) : pose(some_covariance<6>(random, 0.01)) {
        const Eigen::Vector<double, 5> unit(1, 1, 0.5, 0.5, 1e-3);
        intrinsics.covariance.topLeftCorner<5, 5>() = unit.asDiagonal() * some_covariance<5>(random, 1) * unit.asDiagonal();
        for (int i = 0; i < 6; ++i) {
            for (int k = 0; k < 5; ++k) intrinsics.pose_by(i, k) = 0.01 * random.normal() / unit[k];
        }
        Eigen::Matrix<double, Eigen::Dynamic, camera_errors> effect(12, camera_errors);
        for (Eigen::Index i = 0; i < effect.size(); ++i) effect.data()[i] = random.normal();
        root = calibration_root(pose, intrinsics, effect);
    }
    CameraErrors joint() const { return joint_covariance(pose, intrinsics); }
};

TEST(LearnedCalibration, IsWhatItWasWhereNothingWasLearned) {
    Random random(1);
    const Known known(random);
    const LearnedCalibration same = learned_calibration(known.pose, known.intrinsics, known.root, Vector6d::Zero(), Matrix6d::Identity());
    EXPECT_LT((joint_covariance(same.pose_covariance, same.errors) - known.joint()).norm(), 1e-9 * known.joint().norm());
    EXPECT_EQ(same.pose.norm(), 0);
}

TEST(LearnedCalibration, KeepsPoseAndIntrinsicsTied) {
    Random random(2);
    const Known known(random);
    const Matrix6d covariance = 0.02 * Matrix6d::Identity() + 0.01 * some_covariance<6>(random, 1);
    Vector6d mean;
    mean << 1, -0.5, 0.2, 2, -1, 0.3;
    const LearnedCalibration learned = learned_calibration(known.pose, known.intrinsics, known.root, mean, covariance);
    const CameraErrors expected = known.joint() - known.root * (Matrix6d::Identity() - covariance) * known.root.transpose();
    EXPECT_LT((joint_covariance(learned.pose_covariance, learned.errors) - expected).norm(), 1e-8 * expected.norm());
    EXPECT_LT((learned.pose - known.root.topRows<6>() * mean).norm(), 1e-15);
    EXPECT_LT((learned.intrinsics - known.root.bottomRows<most_intrinsics>() * mean).norm(), 1e-12);
    EXPECT_EQ(learned.errors.covariance.bottomRightCorner(most_intrinsics - 5, most_intrinsics - 5).norm(), 0) << "exact numbers stay exact";
    const auto left = symmetric_eigen(learned.pose_covariance);
    EXPECT_GT(left.eigenvalues()[0], -1e-12);
}

TEST(LearnedCalibration, OfAPoseAloneIsItsRoot) {
    Random random(3);
    const Matrix6d pose = some_covariance<6>(random, 0.01);
    CalibrationRoot root = CalibrationRoot::Zero();
    root.topRows<6>() = root_of(pose);
    const LearnedCalibration learned = learned_calibration(pose, {}, root, Vector6d::Ones(), 0.25 * Matrix6d::Identity());
    EXPECT_LT((learned.pose_covariance - 0.25 * pose).norm(), 1e-12 * pose.norm());
    EXPECT_EQ(learned.errors.covariance.norm(), 0);
}

}  // namespace
}  // namespace roomfix
