#include "roomfix/geometry/floor_points.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <optional>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/levenberg_marquardt.hpp"
#include "roomfix/geometry/view.hpp"

namespace roomfix {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// How far a set of points is from lying on one line: the ratio of its two principal spreads, 0 = one line or one point.
double flatness(const Points& points) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const auto& p : points) mean += p / static_cast<double>(points.size());
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const auto& p : points) scatter += (p - mean) * (p - mean).transpose();
    const Eigen::Vector2d spread = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvalues().cwiseMax(0).cwiseSqrt();
    return spread[1] > 0 ? spread[0] / spread[1] : 0;
}

/// Similarity that moves points to mean 0 and mean distance sqrt(2) (Hartley 1997).
Eigen::Matrix3d normaliser(const Points& points) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const auto& p : points) mean += p / static_cast<double>(points.size());
    double distance = 0;
    for (const auto& p : points) distance += (p - mean).norm() / static_cast<double>(points.size());
    const double scale = distance > 0 ? std::sqrt(2.0) / distance : 1;
    Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
    m(0, 0) = m(1, 1) = scale;
    m.topRightCorner<2, 1>() = -scale * mean;
    return m;
}

/// The homography that maps `from` to `to`, by direct linear transform.
Eigen::Matrix3d homography(const Points& from, const Points& to) {
    const Eigen::Matrix3d from_normaliser = normaliser(from);
    const Eigen::Matrix3d to_normaliser = normaliser(to);
    Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
    for (std::size_t i = 0; i < from.size(); ++i) {
        const Eigen::Vector3d a = from_normaliser * from[i].homogeneous();
        const Eigen::Vector3d b = to_normaliser * to[i].homogeneous();
        Eigen::Matrix<double, 2, 9> rows = Eigen::Matrix<double, 2, 9>::Zero();
        rows.block<1, 3>(0, 0) = a.transpose();
        rows.block<1, 3>(0, 6) = -b.x() * a.transpose();
        rows.block<1, 3>(1, 3) = a.transpose();
        rows.block<1, 3>(1, 6) = -b.y() * a.transpose();
        normal += rows.transpose() * rows;
    }
    const auto eigen = symmetric_eigen(normal);
    const Eigen::Matrix<double, 9, 1> h = eigen.eigenvectors().col(0);
    Eigen::Matrix3d inner;
    inner << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
    return to_normaliser.inverse() * inner * from_normaliser;
}

/// map_from_camera from the homography floor (m) -> normalised image, or nothing if no camera above the floor fits.
std::optional<Eigen::Isometry3d> pose_from_homography(const Eigen::Matrix3d& h, const Points& floor) {
    const double scale = 2 / (h.col(0).norm() + h.col(1).norm());
    if (!std::isfinite(scale)) return std::nullopt;
    for (const double sign : {1.0, -1.0}) {
        Eigen::Matrix3d axes;
        axes.col(0) = sign * scale * h.col(0);
        axes.col(1) = sign * scale * h.col(1);
        axes.col(2) = axes.col(0).cross(axes.col(1));
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Eigen::Matrix3d camera_from_map = svd.matrixU() * svd.matrixV().transpose();
        if (camera_from_map.determinant() < 0) continue;
        const Eigen::Vector3d offset = sign * scale * h.col(2);
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.linear() = camera_from_map.transpose();
        pose.translation() = -(pose.linear() * offset);
        bool in_front = true;
        for (const auto& p : floor) in_front &= (camera_from_map * Eigen::Vector3d(p.x(), p.y(), 0) + offset).z() > 0;
        if (in_front && pose.translation().z() > 0) return pose;
    }
    return std::nullopt;
}

struct ViewFit {
    Matrix6d information;  // J^T J, px^-2
    Vector6d gradient;     // J^T residual
    double sum_of_squares = 0;
    int worst = 0;
    double worst_error = 0;
};

std::optional<ViewFit> linearise(const View& view, const std::vector<FloorPoint>& points) {
    ViewFit fit{Matrix6d::Zero(), Vector6d::Zero()};
    for (std::size_t i = 0; i < points.size(); ++i) {
        ViewJacobian jacobian;
        const auto pixel = project_map_point(view, {points[i].map.x(), points[i].map.y(), 0}, &jacobian);
        if (!pixel) return std::nullopt;
        const Eigen::Vector2d residual = points[i].pixel - *pixel;
        fit.information += jacobian.by_pose.transpose() * jacobian.by_pose;
        fit.gradient += jacobian.by_pose.transpose() * residual;
        fit.sum_of_squares += residual.squaredNorm();
        if (residual.norm() > fit.worst_error) {
            fit.worst_error = residual.norm();
            fit.worst = static_cast<int>(i);
        }
    }
    return fit;
}

/// How the pose that fits best moves with the intrinsics; `information`: of the pose, px^-2.
PoseByIntrinsics pose_by_intrinsics(const View& view, const std::vector<FloorPoint>& points, const Matrix6d& information) {
    PoseByIntrinsics mixed = PoseByIntrinsics::Zero();
    for (const FloorPoint& p : points) {
        const Eigen::Vector3d point(p.map.x(), p.map.y(), 0);
        ViewJacobian j;
        IntrinsicsJacobian by_intrinsics;
        if (!project_map_point(view, point, &j) || !project(view.model, view.map_from_camera.pose.inverse() * point, nullptr, &by_intrinsics)) continue;
        mixed += j.by_pose.transpose() * by_intrinsics;
    }
    return -information.ldlt().solve(mixed);
}

/// Levenberg-Marquardt on the six numbers of the pose. Gives the last accepted linearisation.
std::optional<ViewFit> refine(View& view, const std::vector<FloorPoint>& points) {
    auto fit = linearise(view, points);
    if (!fit) return std::nullopt;
    levenberg_marquardt({.least = 1e-15, .most = 1e12}, [&](double damping) {
        const Vector6d step = damped_step(fit->information, fit->gradient, damping);
        View moved = view;
        moved.map_from_camera.pose = perturbed(view.map_from_camera.pose, step);
        const auto next = linearise(moved, points);
        if (!next || !(next->sum_of_squares <= fit->sum_of_squares)) return StepResult::worse;
        view = moved;
        fit = next;
        return step.norm() < 1e-13 ? StepResult::settled : StepResult::better;
    });
    return fit;
}

}  // namespace

Result<FloorPointsPose> camera_pose_from_floor_points(const CameraModel& model, const std::vector<FloorPoint>& points, double sigma) {
    if (points.size() < 4) {
        return Error{fmt::format("{} floor points given, four or more are needed: add points whose place on the floor you know", points.size())};
    }
    Points floor;
    Points rays;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto ray = unproject(model, points[i].pixel);
        if (!ray) {
            return Error{
                fmt::format("floor point {} at pixel ({:g}, {:g}) is outside what the lens model can see: check the "
                            "pixel, the intrinsics and the distortion",
                            i + 1, points[i].pixel.x(), points[i].pixel.y())};
        }
        floor.push_back(points[i].map);
        rays.push_back(*ray);
    }
    if (flatness(floor) < 0.02 || flatness(rays) < 0.002) {
        return Error{"the floor points lie (nearly) on one line: choose points that span an area, such as the corners of a tile"};
    }

    const auto start = pose_from_homography(homography(floor, rays), floor);
    if (!start) {
        return Error{
            "no camera above the floor sees these floor points like this: check their order, and that map x and y "
            "are right-handed seen from above"};
    }
    View view{model, {*start, Matrix6d::Zero()}};
    const auto fit = refine(view, points);
    if (!fit) return Error{"the camera pose could not be refined on the floor points: check the pixels and the intrinsics"};
    const auto spectrum = symmetric_eigen(fit->information);
    if (!(spectrum.eigenvalues()[0] > 1e-9 * spectrum.eigenvalues()[5])) {
        return Error{
            "the floor points do not fix the camera's pose (three of them on one line and the rest too close): add "
            "points that span an area"};
    }

    FloorPointsPose result;
    result.worst = fit->worst;
    result.worst_error = fit->worst_error;
    const double freedom = 2.0 * static_cast<double>(points.size()) - 6;
    const double variance = fit->sum_of_squares / freedom;
    result.rms = std::sqrt(variance);
    // Reduced chi-square above 1 + 3 standard deviations: the stated noise is too small, believe the points.
    const bool noisier = variance > sigma * sigma * (1 + 3 * std::sqrt(2 / freedom));
    result.map_from_camera.pose = view.map_from_camera.pose;
    result.by_intrinsics = pose_by_intrinsics(view, points, fit->information);
    result.map_from_camera.covariance = fit->information.inverse() * (noisier ? variance : sigma * sigma);
    return result;
}

}  // namespace roomfix
