// What is not known exactly of a camera's calibration: its pose and its intrinsics together.
#pragma once

#include <Eigen/Core>

#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

/// Derivatives of a pose's error vector (UncertainPose3) by the intrinsics.
using PoseByIntrinsics = Eigen::Matrix<double, 6, most_intrinsics>;

struct IntrinsicsErrors {
    IntrinsicsMatrix covariance = IntrinsicsMatrix::Zero();  // in the order of IntrinsicsVector
    /// The camera's pose was found with these intrinsics: had they been others, it would be another, too.
    PoseByIntrinsics pose_by = PoseByIntrinsics::Zero();

    bool any() const { return covariance.diagonal().maxCoeff() > 0; }
};

/// All errors of a camera: the six of its pose, then those of its intrinsics.
constexpr int camera_errors = 6 + most_intrinsics;
using CameraErrors = Eigen::Matrix<double, camera_errors, camera_errors>;
/// As six independent errors of unit variance, one column each: the product with its transpose is the covariance.
using CalibrationRoot = Eigen::Matrix<double, camera_errors, 6>;

/// The joint covariance; `pose`: what the intrinsics have no part in.
CameraErrors joint_covariance(const Matrix6d& pose, const IntrinsicsErrors& intrinsics);

/// A matrix whose product with its transpose is the covariance.
Matrix6d root_of(const Matrix6d& covariance);

/// Six independent errors that have nearly all of the effect: exact where only the pose is uncertain, the six strongest otherwise.
/// `effect`: what matters (rows, in one unit) by all errors (columns).
CalibrationRoot calibration_root(const Matrix6d& pose, const IntrinsicsErrors& intrinsics, const Eigen::Matrix<double, Eigen::Dynamic, camera_errors>& effect);

/// A camera's calibration once its six independent errors were measured.
struct LearnedCalibration {
    Vector6d pose = Vector6d::Zero();                        // the error vector that its pose had
    IntrinsicsVector intrinsics = IntrinsicsVector::Zero();  // to be added to them
    Matrix6d pose_covariance = Matrix6d::Zero();             // what the intrinsics have no part in
    IntrinsicsErrors errors;
};

/// `pose`, `intrinsics`: what was known before. `root`: of them. `mean`, `covariance`: of the six errors.
LearnedCalibration learned_calibration(const Matrix6d& pose, const IntrinsicsErrors& intrinsics, const CalibrationRoot& root, const Vector6d& mean,
                                       const Matrix6d& covariance);

/// Pixels spread evenly over the picture, where effects are looked at.
Eigen::Matrix<double, 2, Eigen::Dynamic> spread_pixels(const CameraModel& model);

}  // namespace roomfix
