// Many simulated drives through one hall: are the tracker's errors as large as it says, and as small as they can be?
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "roomfix/evaluate/hall.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix {

struct DriveOptions {
    HallSenses senses;
    double seconds = 12;
    double blind_from = 1e9;  // s: from then on nothing but odometry
    std::uint64_t seed = 1;
    double scale_error = 0;  // of the odometry, added to what its prior says
    double drift_error = 0;  // rad/s, likewise
    bool smoothed = false;   // judge what is known after the drive, not during it
};

/// One moment of a drive.
struct TrackerSample {
    double time = 0;
    bool found = false;
    bool yaw_known = false;
    Pose2 truth, fix;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d bound = Eigen::Matrix3d::Identity();  // posterior Cramer-Rao bound at the truth

    void take(const Fix& known);
};

/// A robot that accelerates at random, as the motion model says, and stays in the hall. Samples every 0.5 s after the third second.
std::vector<TrackerSample> simulated_drive(const DriveOptions& options);

/// What a drive tells of one camera's calibration: error vectors of its pose in the map or on the robot.
struct CalibratedByDrive {
    std::string camera;
    Vector6d truth;       // drawn from `before`
    Vector6d found;       // by calibrating with the drive
    Matrix6d covariance;  // of that
    Matrix6d before;
};
std::vector<CalibratedByDrive> calibrations_by_drive(DriveOptions options);

struct SiteCalibrationResult {
    std::string name;
    int cameras = 0;                       // calibrated, over all runs
    double coverage = 0;                   // part of their true numbers inside the 95 % intervals
    double nees = 0;                       // mean of a camera's six numbers
    double turn_before = 0, turn_now = 0;  // rad, root mean square
};

/// `runs` drives of `seconds`, each with other errors of all calibrations.
SiteCalibrationResult measure_site_calibration(const std::string& name, const HallSenses& senses, double seconds, int runs, std::uint64_t seed,
                                               const std::function<void(double)>& progress = {});

struct ConsistencyResult {
    std::string name;
    int runs = 0;
    int samples = 0;
    int lost = 0;
    int dimensions = 3;                  // 2 where the yaw cannot be known
    double nees = 0;                     // mean over runs
    double nees_low = 0, nees_high = 0;  // 95 % band of that mean for a truthful covariance
    double rmse = 0;                     // m
    double yaw_rmse = 0;                 // rad
    double bound = 0;                    // m
    double yaw_bound = 0;                // rad
};

/// `runs` drives with one set of senses. NEES is that of the last sample of each drive, so that runs are independent.
ConsistencyResult measure_consistency(const std::string& name, const HallSenses& senses, int runs, std::uint64_t seed,
                                      const std::function<void(double)>& progress = {}, bool smoothed = false);

/// The ten sets of senses that the product promises to be truthful with.
std::vector<std::pair<std::string, HallSenses>> all_senses();

/// Part of `runs` drives whose true place lies inside the 95 % ellipse after ten seconds on odometry alone.
double blind_coverage(int runs, std::uint64_t seed, double scale_error, double drift_error);

}  // namespace roomfix
