// How well anybody could locate a robot from a landmark's pixels: the Cramer-Rao bound of the rendered picture.
#pragma once

#include <Eigen/Core>

#include "roomfix/simulate/ceiling_scene.hpp"

namespace roomfix {

/// Information of the LEDs' unsaturated pixels about x, y and yaw of a robot at `truth` (m, rad), for the sensor's noise and rounding.
/// Each LED's brightness and the ground around it (level and slope) are unknown, too; everything else is known. Zero if no LED is in
/// view.
Eigen::Matrix3d landmark_information(const CeilingScene& scene, const CameraOnRobot& camera, const SensorModel& sensor, const GlareModel& glare,
                                     const Pose2& truth);

/// Information of one range.
Eigen::Matrix3d range_information(const Eigen::Vector3d& beacon, const Eigen::Vector3d& receiver, double sigma, const Pose2& truth);

}  // namespace roomfix
