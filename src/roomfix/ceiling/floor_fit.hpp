// A robot's pose from points of known place that its camera sees and from ranges to beacons: any mixture of them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "roomfix/geometry/onboard_view.hpp"
#include "roomfix/observation/range_noise.hpp"

namespace roomfix {

/// A landmark's point in the picture.
struct SeenPoint {
    Eigen::Vector3d map;         // m
    Eigen::Vector2d pixel;       // px
    Eigen::Matrix2d covariance;  // px^2
    int group = 0;               // 0..7: points of one landmark share the error of its position
    double group_sigma = 0;      // m, of each coordinate
};

/// A range from the robot's receiver to a beacon.
struct HeardRange {
    Eigen::Vector3d beacon;                              // m, map
    double range = 0;                                    // m
    double sigma = 0.02;                                 // m
    Eigen::Vector3d receiver = Eigen::Vector3d::Zero();  // m, robot frame
};

struct FloorEvidence {
    const CameraOnRobot* camera = nullptr;  // may be null where `points` is empty
    std::span<const SeenPoint> points;
    std::span<const HeardRange> ranges;
    LateModel late;
};

struct FloorFit {
    Pose2 pose;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  // x, y, yaw; with the mount's and the landmarks' own uncertainty
    double pixel_rms = 0;                                      // px, per coordinate
    bool yaw_known = false;
};

/// The map point's place in the robot frame, seen at `pixel`, if it is `height` m above the floor (m).
std::optional<Eigen::Vector2d> point_at_height(const CameraOnRobot& camera, const Eigen::Vector2d& pixel, double height);

/// Iterated weighted least squares from `start`: pixels with their covariances, ranges by the late-only model. Without points the yaw
/// stays where it was and is not known. Nothing if the evidence does not fix x and y.
std::optional<FloorFit> fit_on_floor(const FloorEvidence& evidence, const Pose2& start);

/// Log-likelihood of the ranges alone for a robot at `pose`.
double range_score(const FloorEvidence& evidence, const Pose2& pose);

/// The pose that best lays points of the robot frame (m, x and y) onto points of the map: closed form. Needs two different points.
/// Source: Umeyama 1991, in the plane, without scale.
Pose2 align(std::span<const Eigen::Vector2d> robot_points, std::span<const Eigen::Vector2d> map_points);

}  // namespace roomfix
