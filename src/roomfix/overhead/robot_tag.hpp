// A fixed camera sees the AprilTag on a robot's top.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/tag_detector.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct RobotTagFit {
    Pose2 pose;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();                          // x, y, yaw; m, rad; with the camera's calibration in it
    Eigen::Matrix<double, 3, 6> by_calibration = Eigen::Matrix<double, 3, 6>::Zero();  // how the pose moves with the view's six independent errors
    double pixel_rms = 0;                                                              // px, per coordinate
};

/// The pose of a robot on the floor whose tag's corners (order of own_points()) are seen at `corners` (px), each coordinate with noise
/// `sigma` (px). Nothing if no pose on the floor explains them within `largest_rms` px.
std::optional<RobotTagFit> fit_robot_tag(const View& view, const SiteRobot& robot, const std::array<Eigen::Vector2d, 4>& corners, double sigma,
                                         double largest_rms = 2);

/// A robot found by its tag.
struct TaggedRobot {
    int robot = 0;  // index in `robots`
    RobotTagFit fit;
    std::array<Eigen::Vector2d, 4> corners;  // px, in the order of own_points()
    double sigma = 0;                        // px, of each coordinate
};

/// The robots whose tags a fixed camera sees in a frame.
std::vector<TaggedRobot> find_tagged_robots(const View& view, const std::vector<SiteRobot>& robots, TagDetector& detector, LumaView frame);

}  // namespace roomfix
