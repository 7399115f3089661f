#include "roomfix/geometry/calibration.hpp"

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

template <int N>
Eigen::Matrix<double, N, N> symmetric_root(const Eigen::Matrix<double, N, N>& covariance) {
    const Eigen::LDLT<Eigen::Matrix<double, N, N>> factor(covariance);
    return factor.transpositionsP().transpose() * (factor.matrixL().toDenseMatrix() * factor.vectorD().cwiseMax(0).cwiseSqrt().asDiagonal());
}

}  // namespace

Matrix6d root_of(const Matrix6d& covariance) { return symmetric_root<6>(covariance); }

CameraErrors joint_covariance(const Matrix6d& pose, const IntrinsicsErrors& intrinsics) {
    CameraErrors joint;
    joint.topLeftCorner<6, 6>() = pose + intrinsics.pose_by * intrinsics.covariance * intrinsics.pose_by.transpose();
    joint.topRightCorner<6, most_intrinsics>() = intrinsics.pose_by * intrinsics.covariance;
    joint.bottomLeftCorner<most_intrinsics, 6>() = joint.topRightCorner<6, most_intrinsics>().transpose();
    joint.bottomRightCorner<most_intrinsics, most_intrinsics>() = intrinsics.covariance;
    return joint;
}

CalibrationRoot calibration_root(const Matrix6d& pose, const IntrinsicsErrors& intrinsics, const Eigen::Matrix<double, Eigen::Dynamic, camera_errors>& effect) {
    CalibrationRoot root = CalibrationRoot::Zero();
    if (!intrinsics.any()) {
        root.topRows<6>() = root_of(pose);
        return root;
    }
    CameraErrors whole = CameraErrors::Zero();
    const IntrinsicsMatrix own = symmetric_root<most_intrinsics>(intrinsics.covariance);
    whole.topLeftCorner<6, 6>() = root_of(pose);
    whole.topRightCorner<6, most_intrinsics>() = intrinsics.pose_by * own;
    whole.bottomRightCorner<most_intrinsics, most_intrinsics>() = own;
    // Directions of the unit errors by what they do: the strongest come last.
    const Eigen::Matrix<double, Eigen::Dynamic, camera_errors> done = effect * whole;
    const auto directions = symmetric_eigen(done.transpose() * done);
    return whole * directions.eigenvectors().rightCols<6>();
}

LearnedCalibration learned_calibration(const Matrix6d& pose, const IntrinsicsErrors& intrinsics, const CalibrationRoot& root, const Vector6d& mean,
                                       const Matrix6d& covariance) {
    LearnedCalibration learned;
    learned.pose = root.topRows<6>() * mean;
    learned.intrinsics = root.bottomRows<most_intrinsics>() * mean;
    CameraErrors joint = joint_covariance(pose, intrinsics) - root * (Matrix6d::Identity() - covariance) * root.transpose();
    joint = (0.5 * (joint + joint.transpose())).eval();
    learned.errors.covariance = joint.bottomRightCorner<most_intrinsics, most_intrinsics>();
    // The numbers have very different units, and some are exact.
    const IntrinsicsVector sigma = learned.errors.covariance.diagonal().cwiseMax(0).cwiseSqrt();
    const IntrinsicsVector per_sigma = (sigma.array() > 0).select(sigma.cwiseInverse(), 0.0);
    const IntrinsicsMatrix correlation = per_sigma.asDiagonal() * learned.errors.covariance * per_sigma.asDiagonal();
    const Eigen::MatrixXd pseudo_inverse = Eigen::MatrixXd(correlation).completeOrthogonalDecomposition().pseudoInverse();
    const IntrinsicsMatrix inverse = per_sigma.asDiagonal() * pseudo_inverse * per_sigma.asDiagonal();
    const PoseByIntrinsics with = joint.topRightCorner<6, most_intrinsics>();
    learned.errors.pose_by = with * inverse;
    learned.pose_covariance = joint.topLeftCorner<6, 6>() - learned.errors.pose_by * with.transpose();
    learned.pose_covariance = (0.5 * (learned.pose_covariance + learned.pose_covariance.transpose())).eval();
    return learned;
}

Eigen::Matrix<double, 2, Eigen::Dynamic> spread_pixels(const CameraModel& model) {
    constexpr int across = 9, down = 7;
    Eigen::Matrix<double, 2, Eigen::Dynamic> pixels(2, across * down);
    for (int i = 0; i < across * down; ++i) {
        const double u = (i % across + 0.5) / across, v = (i / across + 0.5) / down;
        pixels.col(i) << u * (model.width - 1), v * (model.height - 1);
    }
    return pixels;
}

}  // namespace roomfix
