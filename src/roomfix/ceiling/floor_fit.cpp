#include "roomfix/ceiling/floor_fit.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/levenberg_marquardt.hpp"

namespace roomfix {
namespace {

constexpr double no_yaw_sigma = std::numbers::pi / std::numbers::sqrt3;  // of a yaw that nobody knows
constexpr double known_yaw_sigma = 0.5;                                  // rad: below, the yaw is known
constexpr std::size_t most_groups = 8;

Eigen::Matrix3d robot_from_map_rotation(double yaw) { return Eigen::AngleAxisd(-yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(); }

struct Linearised {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    double log_likelihood = 0;
    double pixel_squares = 0;
    bool visible = true;  // all points are in front of the camera
};

/// How the solution moves with what is taken for known.
struct Nuisance {
    Eigen::Matrix<double, 3, camera_errors> by_camera = Eigen::Matrix<double, 3, camera_errors>::Zero();
    std::array<Eigen::Matrix3d, most_groups> by_group;
    Nuisance() { by_group.fill(Eigen::Matrix3d::Zero()); }
};

void add_points(const FloorEvidence& evidence, const Pose2& pose, Linearised& l, Nuisance* nuisance) {
    for (const SeenPoint& point : evidence.points) {
        SeenPointJacobian j;
        const auto pixel = predict_point(*evidence.camera, pose, point.map, &j);
        if (!pixel) {
            l.visible = false;
            return;
        }
        const Eigen::Vector2d residual = point.pixel - *pixel;
        const Eigen::Matrix2d weight = point.covariance.inverse();
        const Eigen::Matrix<double, 3, 2> back = j.by_pose.transpose() * weight;
        l.information += back * j.by_pose;
        l.gradient += back * residual;
        l.log_likelihood -= 0.5 * residual.dot(weight * residual);
        l.pixel_squares += residual.squaredNorm();
        if (!nuisance) continue;
        nuisance->by_camera.leftCols<6>() -= back * j.by_mount;
        nuisance->by_camera.rightCols<most_intrinsics>() -= back * j.by_intrinsics;
        nuisance->by_group[static_cast<std::size_t>(point.group)] -= back * j.by_point * point.group_sigma;
    }
}

void add_ranges(const FloorEvidence& evidence, const Pose2& pose, Linearised& l) {
    for (const HeardRange& heard : evidence.ranges) {
        const Eigen::Vector3d arm = robot_from_map_rotation(pose.yaw).transpose() * heard.receiver;
        const Eigen::Vector3d way = Eigen::Vector3d(pose.x, pose.y, 0) + arm - heard.beacon;
        const double distance = std::max(way.norm(), 1e-9);
        const Eigen::Vector3d along = way / distance;
        const Eigen::Vector3d slope(along.x(), along.y(), along.dot(Eigen::Vector3d::UnitZ().cross(arm)));
        const RangeLikelihood likelihood = range_likelihood(heard.range - distance, heard.sigma, evidence.late);
        l.log_likelihood += likelihood.log_density;
        l.information += likelihood.curvature * slope * slope.transpose();
        l.gradient -= likelihood.slope * slope;
    }
}

Linearised linearise(const FloorEvidence& evidence, const Pose2& pose, Nuisance* nuisance = nullptr) {
    Linearised l;
    add_points(evidence, pose, l, nuisance);
    add_ranges(evidence, pose, l);
    l.information(2, 2) += 1 / (no_yaw_sigma * no_yaw_sigma);
    return l;
}

}  // namespace

std::optional<Eigen::Vector2d> point_at_height(const CameraOnRobot& camera, const Eigen::Vector2d& pixel, double height) {
    const auto ray = unproject(camera.model, pixel);
    if (!ray) return std::nullopt;
    const Eigen::Isometry3d& mount = camera.robot_from_camera.pose;
    const Eigen::Vector3d direction = mount.linear() * ray->homogeneous();
    const double along = (height - mount.translation().z()) / direction.z();
    if (!(along > 0) || !std::isfinite(along)) return std::nullopt;
    return Eigen::Vector2d((mount.translation() + along * direction).head<2>());
}

std::optional<FloorFit> fit_on_floor(const FloorEvidence& evidence, const Pose2& start) {
    Pose2 pose = start;
    Linearised at = linearise(evidence, pose);
    if (!at.visible) return std::nullopt;
    const bool possible = levenberg_marquardt({.start = 1e-6, .rounds = 50}, [&](double damping) {
        const Eigen::Vector3d step = damped_step(at.information, at.gradient, damping);
        if (!step.allFinite()) return StepResult::impossible;
        const Pose2 moved{pose.x + step.x(), pose.y + step.y(), pose.yaw + step.z()};
        const Linearised next = linearise(evidence, moved);
        if (!next.visible || !(next.log_likelihood >= at.log_likelihood - 1e-12 * std::abs(at.log_likelihood))) return StepResult::worse;
        pose = moved;
        at = next;
        return step.head<2>().norm() < 1e-8 && std::abs(step.z()) < 1e-8 ? StepResult::settled : StepResult::better;
    });
    if (!possible) return std::nullopt;
    Nuisance nuisance;
    at = linearise(evidence, pose, &nuisance);
    const Eigen::FullPivLU<Eigen::Matrix3d> factor(at.information);
    if (!factor.isInvertible()) return std::nullopt;
    FloorFit fit;
    fit.pose = {pose.x, pose.y, wrap_angle(pose.yaw)};
    const Eigen::Matrix3d own = factor.inverse();
    fit.covariance = own;
    if (!evidence.points.empty()) {
        const Eigen::Matrix<double, 3, camera_errors> camera = own * nuisance.by_camera;
        fit.covariance += camera * joint_covariance(evidence.camera->robot_from_camera.covariance, evidence.camera->intrinsics) * camera.transpose();
        for (const Eigen::Matrix3d& group : nuisance.by_group) fit.covariance += own * group * group.transpose() * own;
        fit.pixel_rms = std::sqrt(at.pixel_squares / (2 * static_cast<double>(evidence.points.size())));
    }
    fit.covariance = 0.5 * (fit.covariance + fit.covariance.transpose()).eval();
    fit.yaw_known = fit.covariance(2, 2) < known_yaw_sigma * known_yaw_sigma;
    return fit;
}

double range_score(const FloorEvidence& evidence, const Pose2& pose) {
    Linearised l;
    add_ranges(evidence, pose, l);
    return l.log_likelihood;
}

Pose2 align(std::span<const Eigen::Vector2d> robot_points, std::span<const Eigen::Vector2d> map_points) {
    const double count = static_cast<double>(robot_points.size());
    Eigen::Vector2d robot_middle = Eigen::Vector2d::Zero();
    Eigen::Vector2d map_middle = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < robot_points.size(); ++i) {
        robot_middle += robot_points[i] / count;
        map_middle += map_points[i] / count;
    }
    double cosine = 0;
    double sine = 0;
    for (std::size_t i = 0; i < robot_points.size(); ++i) {
        const Eigen::Vector2d a = robot_points[i] - robot_middle;
        const Eigen::Vector2d b = map_points[i] - map_middle;
        cosine += a.dot(b);
        sine += a.x() * b.y() - a.y() * b.x();
    }
    const double yaw = std::atan2(sine, cosine);
    const Eigen::Vector2d place = map_middle - Eigen::Rotation2Dd(yaw) * robot_middle;
    return {place.x(), place.y(), yaw};
}

}  // namespace roomfix
