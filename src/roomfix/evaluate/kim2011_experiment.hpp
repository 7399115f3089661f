// The experiment of Kim 2011: six reference positions below a landmark; printed, trilateration, as published, ours, the bound.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/evaluate/simulated_calibration.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

struct Kim2011Options {
    std::uint64_t seed = 1;
    int seeds = 3;
    int samples = 100;      // per position and seed, each with its own heading
    double tilt = 0;        // rad: true tilt of the mount
    double late = 0;        // part of the ranges that come around a corner
    bool lamp = true;       // a lit tube over the room
    bool baselines = true;  // the published method and trilateration, too
    // From which the lens is calibrated, before the mount is from a turn on the spot; 0 shots: the lens is known exactly, and the mount, too,
    // if it is level.
    BoardPictures board;
};

struct Kim2011Trial {
    int position = 0;
    std::uint64_t seed = 0;
    Pose2 truth;
    std::optional<Pose2> ours;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    Eigen::Vector3d error = Eigen::Vector3d::Zero();
    std::optional<Pose2> published;
    std::optional<Eigen::Vector2d> trilateration;
    std::optional<Eigen::Matrix3d> bound;  // covariance; of some trials per position
    std::string reason;
};

struct Kim2011Report {
    Kim2011Options options;
    std::vector<Kim2011Trial> trials;
    double tilt_sigma = 0;  // rad, of the last calibration

    int lost() const;
    /// Root mean squares, m (position) and rad, over the trials of a position, or of all (-1).
    double ours_rmse(int position = -1) const;
    double published_rmse(int position = -1) const;
    double trilateration_rmse(int position = -1) const;
    double bound_rmse(int position = -1) const;
    double yaw_rms() const;
    double mean_nees() const;
};

Result<Kim2011Report> run_kim2011(const Kim2011Options& options, const std::function<void(double)>& progress = {});

/// The paper's Table 1 beside ours, as text.
std::string kim2011_table(const Kim2011Report& report);

}  // namespace roomfix
