#include "roomfix/calibrate/mount.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

/// Mount (6) and centre (2), with all frames' poses eliminated.
struct Reduced {
    Matrix8d information = Matrix8d::Zero();
    Vector8d gradient = Vector8d::Zero();
    double pixel_squares = 0;
    int pixels = 0;
    // What an error of a landmark's point (m, map) does to the gradient: the same in all frames, so it does not average out.
    std::vector<std::pair<Eigen::Vector3d, Eigen::Matrix<double, 8, 3>>> by_point;

    Eigen::Matrix<double, 8, 3>& of_point(const Eigen::Vector3d& point) {
        for (auto& [known, effect] : by_point) {
            if (known == point) return effect;
        }
        return by_point.emplace_back(point, Eigen::Matrix<double, 8, 3>::Zero()).second;
    }
};

struct State {
    CameraOnRobot camera;
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    std::vector<MountFrame> frames;
};

/// One frame's normal equations: its own pose (3) against mount and centre (8).
struct FrameBlock {
    Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 8> cross = Eigen::Matrix<double, 3, 8>::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

std::optional<FrameBlock> add_frame(const State& state, const MountFrame& frame, double spot_sigma, Reduced& reduced) {
    FrameBlock block;
    for (const SeenPoint& point : frame.points) {
        SeenPointJacobian j;
        const auto pixel = predict_point(state.camera, frame.pose, point.map, &j);
        if (!pixel) return std::nullopt;
        const Eigen::Vector2d residual = point.pixel - *pixel;
        const Eigen::Matrix2d weight = point.covariance.inverse();
        block.own += j.by_pose.transpose() * weight * j.by_pose;
        block.cross.leftCols<6>() += j.by_pose.transpose() * weight * j.by_mount;
        block.gradient += j.by_pose.transpose() * weight * residual;
        reduced.information.topLeftCorner<6, 6>() += j.by_mount.transpose() * weight * j.by_mount;
        reduced.gradient.head<6>() += j.by_mount.transpose() * weight * residual;
        reduced.pixel_squares += residual.squaredNorm();
        reduced.pixels += 2;
    }
    // The robot stayed within spot_sigma of the centre.
    const double tie = 1 / (spot_sigma * spot_sigma);
    const Eigen::Vector2d off = state.centre - Eigen::Vector2d(frame.pose.x, frame.pose.y);
    block.own.topLeftCorner<2, 2>() += tie * Eigen::Matrix2d::Identity();
    block.cross.block<2, 2>(0, 6) -= tie * Eigen::Matrix2d::Identity();
    block.gradient.head<2>() += tie * off;
    reduced.information.bottomRightCorner<2, 2>() += tie * Eigen::Matrix2d::Identity();
    reduced.gradient.tail<2>() -= tie * off;
    const Eigen::Matrix3d inverse = block.own.inverse();
    reduced.information -= block.cross.transpose() * inverse * block.cross;
    reduced.gradient -= block.cross.transpose() * inverse * block.gradient;
    for (const SeenPoint& point : frame.points) {
        SeenPointJacobian j;
        (void)predict_point(state.camera, frame.pose, point.map, &j);
        const Eigen::Matrix<double, 2, 3> weighted = point.covariance.inverse() * j.by_point;
        Eigen::Matrix<double, 8, 3>& effect = reduced.of_point(point.map);
        effect.topRows<6>() -= j.by_mount.transpose() * weighted;
        effect += block.cross.transpose() * inverse * j.by_pose.transpose() * weighted;
    }
    return block;
}

Vector6d prior_sigmas(const MountSettings& s) {
    return (Vector6d() << s.position_sigma, s.position_sigma, s.position_sigma, s.tilt_sigma, s.tilt_sigma, s.heading_sigma).finished();
}

/// How far `pose` is from `start`, as an error vector of UncertainPose3.
Vector6d difference(const Eigen::Isometry3d& pose, const Eigen::Isometry3d& start) {
    const Eigen::AngleAxisd turn(pose.linear() * start.linear().transpose());
    Vector6d d;
    d << pose.translation() - start.translation(), turn.angle() * turn.axis();
    return d;
}

/// A Gauss-Newton step of everything; the size of the mount's change, or nothing if a landmark left the view.
std::optional<double> step(State& state, const Eigen::Isometry3d& start, double spot_sigma, const MountSettings& settings, Reduced& reduced) {
    reduced = {};
    std::vector<FrameBlock> blocks;
    for (const MountFrame& frame : state.frames) {
        const auto block = add_frame(state, frame, spot_sigma, reduced);
        if (!block) return std::nullopt;
        blocks.push_back(*block);
    }
    const Vector6d weight = prior_sigmas(settings).cwiseAbs2().cwiseInverse();
    reduced.information.topLeftCorner<6, 6>() += weight.asDiagonal();
    reduced.gradient.head<6>() -= weight.cwiseProduct(difference(state.camera.robot_from_camera.pose, start));
    const Vector8d d = reduced.information.ldlt().solve(reduced.gradient);
    if (!d.allFinite()) return std::nullopt;
    state.camera.robot_from_camera.pose = perturbed(state.camera.robot_from_camera.pose, d.head<6>());
    state.centre += d.tail<2>();
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        const Eigen::Vector3d own = blocks[i].own.ldlt().solve(blocks[i].gradient - blocks[i].cross * d);
        Pose2& pose = state.frames[i].pose;
        pose = {pose.x + own.x(), pose.y + own.y(), wrap_angle(pose.yaw + own.z())};
    }
    return d.norm();
}

/// The part of the circle that the headings cover: all of it but the largest gap, rad.
double covered_angle(std::vector<double> headings) {
    std::sort(headings.begin(), headings.end());
    double gap = headings.front() + 2 * std::numbers::pi - headings.back();
    for (std::size_t i = 1; i < headings.size(); ++i) gap = std::max(gap, headings[i] - headings[i - 1]);
    return 2 * std::numbers::pi - gap;
}

double rms_from_centre(const State& state) {
    double squares = 0;
    for (const MountFrame& frame : state.frames) squares += (Eigen::Vector2d(frame.pose.x, frame.pose.y) - state.centre).squaredNorm();
    return std::sqrt(squares / (2 * std::max<double>(1, static_cast<double>(state.frames.size()) - 2)));
}

/// How far off a level camera's fixes would be because of the mount's error `d`, at a rise (m) above it: robot frame, linear.
Eigen::Matrix<double, 2, 6> offset_jacobian(double rise) {
    Eigen::Matrix<double, 2, 6> j = Eigen::Matrix<double, 2, 6>::Zero();
    j(0, 0) = j(1, 1) = 1;
    j(0, 4) = rise;  // a turn about y moves what is above along x
    j(1, 3) = -rise;
    return j;
}

}  // namespace

Result<MountCalibration> calibrate_mount(const CameraOnRobot& start, std::vector<MountFrame> frames, const MountSettings& settings) {
    std::erase_if(frames, [](const MountFrame& f) { return f.points.empty(); });
    if (static_cast<int>(frames.size()) < settings.least_frames) {
        return Error{fmt::format("only {} pictures show a landmark, {} are needed: let the robot turn below one", frames.size(), settings.least_frames)};
    }
    std::vector<double> headings;
    for (const MountFrame& frame : frames) headings.push_back(frame.pose.yaw);
    const double turned = covered_angle(headings);
    if (turned < settings.least_turn) {
        return Error{fmt::format("the robot turned through {:.0f} deg only: let it make a full turn on the spot", degrees(turned))};
    }
    State state{start, Eigen::Vector2d::Zero(), std::move(frames)};
    for (const MountFrame& frame : state.frames) state.centre += Eigen::Vector2d(frame.pose.x, frame.pose.y) / static_cast<double>(state.frames.size());
    double spot_sigma = 0.01;  // m, to begin with
    Reduced reduced;
    for (int round = 0; round < 30; ++round) {
        const auto change = step(state, start.robot_from_camera.pose, spot_sigma, settings, reduced);
        if (!change) return Error{"the mount in the site file is too far off: a landmark would be out of view; correct its quaternion by hand first"};
        const double seen = std::clamp(rms_from_centre(state), 2e-4, 0.05);
        const bool settled = std::abs(seen - spot_sigma) < 0.02 * spot_sigma;
        spot_sigma = seen;
        if (*change < 1e-9 && settled) break;
    }
    MountCalibration result;
    Matrix8d covariance = reduced.information.inverse();
    Matrix8d systematic = Matrix8d::Zero();
    for (const auto& [point, effect] : reduced.by_point) {
        const Eigen::Matrix<double, 8, 3> moved = covariance * effect * settings.point_sigma;
        systematic += moved * moved.transpose();
    }
    covariance += systematic;
    result.robot_from_camera.pose = state.camera.robot_from_camera.pose;
    covariance = 0.5 * (covariance + covariance.transpose()).eval();
    result.robot_from_camera.covariance = covariance.topLeftCorner<6, 6>();
    result.frames = static_cast<int>(state.frames.size());
    result.turned = turned;
    result.spot_sigma = spot_sigma;
    result.pixel_rms = std::sqrt(reduced.pixel_squares / reduced.pixels);
    const Eigen::Vector3d axis = result.robot_from_camera.pose.linear().col(2);
    result.tilt = std::atan2(axis.head<2>().norm(), std::abs(axis.z()));
    result.tilt_sigma = std::sqrt(std::max(covariance(3, 3), covariance(4, 4)));
    double rise = 0;
    for (const SeenPoint& p : state.frames[0].points) rise = p.map.z() - result.robot_from_camera.pose.translation().z();
    const Vector6d moved = difference(result.robot_from_camera.pose, start.robot_from_camera.pose);
    const Eigen::Matrix<double, 2, 6> j = offset_jacobian(rise);
    result.offset = (j * moved).norm();
    const Vector6d prior = prior_sigmas(settings);
    const char* names[] = {"its place along the robot's x", "its place along the robot's y", "its height", "its tilt about x", "its tilt about y",
                           "its turn about the vertical"};
    for (int i = 0; i < 6; ++i) {
        if (covariance(i, i) > 0.7 * prior[i] * prior[i]) result.not_observed.emplace_back(names[i]);
    }
    return result;
}

}  // namespace roomfix
