// Where a camera sits on its robot and how it is tilted, from pictures taken while the robot turns on the spot, or turns and drives.
#pragma once

#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/ceiling/floor_fit.hpp"
#include "roomfix/estimate/odometry_track.hpp"

namespace roomfix {

/// What one picture shows: landmarks whose place is known, and about where the robot is.
struct MountFrame {
    std::vector<SeenPoint> points;
    Pose2 pose;
    Nanoseconds time = 0;
};

struct MountSettings {
    double position_sigma = 0.005;  // m: how well the camera's place on the robot was measured, each coordinate
    double tilt_sigma = 0.05;       // rad: how level the camera may be taken for before
    double heading_sigma = 0.03;    // rad: how well its turn about the vertical was set
    double point_sigma = 5e-5;      // m: how exactly each LED sits in its panel, and what its centroid is always off by (each coordinate)
    double least_turn = 3.1;        // rad of headings that the frames of a turn on the spot must cover
    int least_frames = 8;
    double outlier = 6;  // standard deviations: a frame that fits worse shows something else
    // Of wheels, as far as they are there.
    double scale_sigma = 0.02;  // of the measured way: a constant part that is off
    double drift_sigma = 0.01;  // rad/s
    OdometryNoise noise;
    double least_drive = 0.2;       // m, or ...
    double least_drive_turn = 0.5;  // rad: a session with less shows nothing
};

struct MountCalibration {
    UncertainPose3 robot_from_camera;                           // as if the intrinsics were exact
    PoseByIntrinsics by_intrinsics = PoseByIntrinsics::Zero();  // how it moves with them
    double tilt = 0;                                            // rad, between the optical axis and the robot's vertical
    double tilt_sigma = 0;                                      // rad
    double offset = 0;                                          // m, how far the mount before would have put fixes off at the landmark's height
    double pixel_rms = 0;                                       // px, per coordinate
    double turned = 0;                                          // rad covered by the headings
    int frames = 0;
    int refused = 0;  // frames that contradict the others
    bool with_wheels = false;
    double spot_sigma = 0;                  // m: how well the robot turned on the spot; without wheels
    double driven = 0;                      // m; with wheels
    double wheel_scale = 0;                 // true way = (1 + scale) * measured way; with wheels
    double wheel_drift = 0;                 // rad/s, true turning = measured turning + drift * time; with wheels
    std::vector<std::string> not_observed;  // what this session cannot tell; the site file's value is kept, with its sigma
};

/// Least squares over the mount (six numbers, each with the settings' prior about `start`) and each frame's pose. With wheels that cover
/// the frames' times, neighbouring frames are tied by what the wheels drove, and the wheels' scale and drift are estimated, too. Without,
/// the robot is taken to turn on the spot: the spot's centre and how exactly the robot kept to it are estimated. Errors: too few frames, too little
/// turning, no motion.
Result<MountCalibration> calibrate_mount(const CameraOnRobot& start, std::vector<MountFrame> frames, const MountSettings& settings = {},
                                         const OdometryTrack& wheels = OdometryTrack());

/// How far a mount's tilt puts fixes off under a ceiling 2.5 m above (m, standard deviation of both directions together).
double tilt_error(const Matrix6d& robot_from_camera);

}  // namespace roomfix
