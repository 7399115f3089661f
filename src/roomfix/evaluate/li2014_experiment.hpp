// The experiment of Li et al. 2014 in simulation: its test points, its method as published, ours, and the bound.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/evaluate/simulated_calibration.hpp"
#include "roomfix/overhead/overhead_observer.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {

struct Li2014Options {
    std::uint64_t seed = 1;
    int seeds = 3;            // runs with other noise, clicks, robot headings and size errors
    int fixes_per_point = 1;  // with other headings and noise
    double hidden = 0;        // part of the robot that something stands in front of
    double light = 1;         // light of the frames against the background's
    bool scatter = false;     // place the robot anywhere within 0.4 m of the test points instead of on them
    bool published = true;    // run the published method too
    // From which each camera's lens is calibrated, before its pose is from the floor's joints; 0 shots: the lens is known exactly, and the
    // pose is from clicked floor points.
    BoardPictures board;
};

/// One fix of one test point.
struct Li2014Trial {
    int point = 0;  // index in li2014_test_points()
    std::uint64_t seed = 0;
    Pose2 truth;
    std::optional<Pose2> ours;  // nothing: no fix
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    Eigen::Vector3d error = Eigen::Vector3d::Zero();  // ours - truth, yaw modulo a quarter turn
    std::optional<Eigen::Vector2d> published;         // m
    double bound = 0;                                 // m: root of the trace of the position bound, calibration included
    double bound_pixels = 0;                          // m: without the calibration's part
    std::string reason;                               // why there is no fix
};

struct Li2014Report {
    std::vector<Li2014Trial> trials;
    double position_error(const Li2014Trial& t) const { return t.error.head<2>().norm(); }
    int lost() const;
    std::vector<double> position_errors() const;   // m, of all fixes
    std::vector<double> yaw_errors() const;        // rad
    std::vector<double> published_errors() const;  // m
    double mean_nees() const;                      // 3 unknowns
};

/// Runs the experiment; `progress` gets values from 0 to 1.
Result<Li2014Report> run_li2014(const Li2014Options& options, const std::function<void(double)>& progress = {});

/// Table 1 side by side, as text.
std::string li2014_table(const Li2014Report& report);

/// An upright box between camera and robot that hides about `part` of the robot's pixels: a post from the left or right,
/// or a low wall, as `side` (0, 1, 2) says.
Solid occluder_for(const Scene& scene, const View& view, const std::vector<Solid>& robot, const Pose2& place, double part, int side);

}  // namespace roomfix
