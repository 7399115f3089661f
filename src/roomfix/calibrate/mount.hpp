// Where a camera sits on its robot and how it is tilted, from pictures taken while the robot turns on the spot.
#pragma once

#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/ceiling/floor_fit.hpp"

namespace roomfix {

/// What one picture shows: landmarks whose place is known, and about where the robot is.
struct MountFrame {
    std::vector<SeenPoint> points;
    Pose2 pose;
};

struct MountSettings {
    double position_sigma = 0.005;  // m: how well the camera's place on the robot was measured, each coordinate
    double tilt_sigma = 0.05;       // rad: how level the camera may be taken for before
    double heading_sigma = 0.01;    // rad: how well its turn about the vertical was set
    double point_sigma = 5e-5;      // m: how exactly each LED sits in its panel, and what its centroid is always off by (each coordinate)
    double least_turn = 3.1;        // rad of headings that the frames must cover
    int least_frames = 8;
};

struct MountCalibration {
    UncertainPose3 robot_from_camera;
    double tilt = 0;        // rad, between the optical axis and the robot's vertical
    double tilt_sigma = 0;  // rad
    double offset = 0;      // m, how far a level mount would have put fixes off at the landmark's height
    double pixel_rms = 0;   // px, per coordinate
    double spot_sigma = 0;  // m: how well the robot turned on the spot
    double turned = 0;      // rad covered by the headings
    int frames = 0;
    std::vector<std::string> not_observed;  // what this session cannot tell; the site file's value is kept, with its sigma
};

/// Least squares over the mount (six numbers, each with the settings' prior about `start`), the spot's centre and each frame's pose;
/// how exactly the robot kept to the spot is estimated, too. Errors: too few frames, or too little turning.
Result<MountCalibration> calibrate_mount(const CameraOnRobot& start, std::vector<MountFrame> frames, const MountSettings& settings = {});

}  // namespace roomfix
