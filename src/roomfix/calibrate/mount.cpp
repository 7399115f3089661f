#include "roomfix/calibrate/mount.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/median.hpp"

namespace roomfix {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// The unknowns' places in the normal equations: the mount (6), two that all frames share (the spot's centre, or the wheels' scale and
/// drift), then each frame's pose (3).
constexpr Eigen::Index first_shared = 6, first_frame = 8;
constexpr double most_wobble = 0.05;  // m: a robot that leaves its spot farther does not turn on it
constexpr Eigen::Index of_frame(std::size_t frame) { return first_frame + 3 * static_cast<Eigen::Index>(frame); }

/// Normal equations of everything.
class Equations {
public:
    explicit Equations(std::size_t frames) : gradient(Eigen::VectorXd::Zero(of_frame(frames))) {}

    /// A residual (measured - predicted), by unknowns that start at `at_a` and at `at_b`.
    template <int Rows, int A, int B>
    void add(const Eigen::Matrix<double, Rows, 1>& residual, const Eigen::Matrix<double, Rows, Rows>& weight, Eigen::Index at_a,
             const Eigen::Matrix<double, Rows, A>& by_a, Eigen::Index at_b, const Eigen::Matrix<double, Rows, B>& by_b) {
        gradient.segment<A>(at_a) += by_a.transpose() * weight * residual;
        gradient.segment<B>(at_b) += by_b.transpose() * weight * residual;
        put(at_a, at_a, by_a.transpose() * weight * by_a);
        put(at_b, at_b, by_b.transpose() * weight * by_b);
        put(at_a, at_b, by_a.transpose() * weight * by_b);
        put(at_b, at_a, by_b.transpose() * weight * by_a);
    }
    template <class Block>
    void put(Eigen::Index row, Eigen::Index column, const Block& block) {
        for (Eigen::Index c = 0; c < block.cols(); ++c) {
            for (Eigen::Index r = 0; r < block.rows(); ++r) entries_.emplace_back(static_cast<int>(row + r), static_cast<int>(column + c), block(r, c));
        }
    }
    Sparse information() const {
        Sparse matrix(gradient.size(), gradient.size());
        matrix.setFromTriplets(entries_.begin(), entries_.end());
        return matrix;
    }

    Eigen::VectorXd gradient;
    double pixel_squares = 0;
    int pixels = 0;

private:
    std::vector<Eigen::Triplet<double>> entries_;
};

struct State {
    CameraOnRobot camera;
    Eigen::Vector2d shared = Eigen::Vector2d::Zero();
    std::vector<MountFrame> frames;
    std::vector<std::optional<OdometryStep>> driven;  // to each frame from the one before; empty without wheels
    double spot_sigma = 0.01;                         // m, without wheels

    bool with_wheels() const { return !driven.empty(); }
};

Vector6d prior_sigmas(const MountSettings& s) {
    return (Vector6d() << s.position_sigma, s.position_sigma, s.position_sigma, s.tilt_sigma, s.tilt_sigma, s.heading_sigma).finished();
}

/// The landmarks' points that a frame shows. False if one would be out of view.
bool add_points(const State& state, std::size_t i, Equations& equations) {
    for (const SeenPoint& point : state.frames[i].points) {
        SeenPointJacobian j;
        const auto pixel = predict_point(state.camera, state.frames[i].pose, point.map, &j);
        if (!pixel) return false;
        const Eigen::Vector2d residual = point.pixel - *pixel;
        equations.add<2, 6, 3>(residual, point.covariance.inverse(), 0, j.by_mount, of_frame(i), j.by_pose);
        equations.pixel_squares += residual.squaredNorm();
        equations.pixels += 2;
    }
    return true;
}

/// The robot stayed within spot_sigma of the centre.
void add_spot(const State& state, std::size_t i, Equations& equations) {
    const Pose2& pose = state.frames[i].pose;
    const Eigen::Matrix2d one = Eigen::Matrix2d::Identity();
    equations.add<2, 2, 2>(state.shared - Eigen::Vector2d(pose.x, pose.y), one / (state.spot_sigma * state.spot_sigma), first_shared, -one, of_frame(i), one);
}

/// What the wheels drove from the frame before.
void add_step(const State& state, std::size_t i, const OdometryStep& step, const OdometryNoise& noise, Equations& equations) {
    const Pose2& a = state.frames[i - 1].pose;
    const Pose2& b = state.frames[i].pose;
    const double scale = state.shared[0], drift = state.shared[1], dt = step.seconds;
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-(a.yaw + 0.5 * drift * dt)).toRotationMatrix();
    const Eigen::Vector2d way = turn * Eigen::Vector2d(b.x - a.x, b.y - a.y);
    const Eigen::Vector2d by_angle(way.y(), -way.x());
    Eigen::Vector3d residual;
    residual << (1 + scale) * step.way - way, step.turned + drift * dt - wrap_angle(b.yaw - a.yaw);
    // By both poses, and by scale and drift, of what is predicted less what is measured.
    Eigen::Matrix<double, 3, 6> by_poses = Eigen::Matrix<double, 3, 6>::Zero();
    by_poses.block<2, 2>(0, 0) = -turn;
    by_poses.block<2, 1>(0, 2) = by_angle;
    by_poses.block<2, 2>(0, 3) = turn;
    by_poses(2, 2) = -1;
    by_poses(2, 5) = 1;
    Eigen::Matrix<double, 3, 2> by_wheels;
    by_wheels << -step.way, 0.5 * dt * by_angle, 0, -dt;
    const double length = step.way.norm(), rest = noise.still * noise.still * dt;
    const Eigen::Vector3d variance(noise.along * noise.along * length + rest, noise.across * noise.across * length + rest,
                                   noise.turn_per_metre * noise.turn_per_metre * length +
                                       noise.turn_per_radian * noise.turn_per_radian * std::abs(step.turned) + noise.still_turn * noise.still_turn * dt);
    const Eigen::Matrix3d weight = variance.cwiseInverse().asDiagonal();
    equations.add<3, 2, 6>(residual, weight, first_shared, by_wheels, of_frame(i - 1), by_poses);
}

/// Nothing if a landmark would be out of view.
std::optional<Equations> equations_of(const State& state, const Eigen::Isometry3d& start, const MountSettings& settings) {
    Equations equations(state.frames.size());
    for (std::size_t i = 0; i < state.frames.size(); ++i) {
        if (!add_points(state, i, equations)) return std::nullopt;
        if (!state.with_wheels()) {
            add_spot(state, i, equations);
        } else if (state.driven[i]) {
            add_step(state, i, *state.driven[i], settings.noise, equations);
        }
    }
    Eigen::Matrix<double, first_frame, 1> weight = Eigen::Matrix<double, first_frame, 1>::Zero();
    weight.head<6>() = prior_sigmas(settings).cwiseAbs2().cwiseInverse();
    equations.gradient.head<6>() -= weight.head<6>().cwiseProduct(error_between(start, state.camera.robot_from_camera.pose));
    if (state.with_wheels()) {
        weight[first_shared] = 1 / (settings.scale_sigma * settings.scale_sigma);
        weight[first_shared + 1] = 1 / (settings.drift_sigma * settings.drift_sigma);
        equations.gradient.segment<2>(first_shared) -= weight.tail<2>().cwiseProduct(state.shared);
    }
    equations.put(0, 0, Eigen::Matrix<double, first_frame, first_frame>(weight.asDiagonal()));
    return equations;
}

/// The size of the mount's change.
double move(State& state, const Eigen::VectorXd& d) {
    state.camera.robot_from_camera.pose = perturbed(state.camera.robot_from_camera.pose, d.head<6>());
    state.shared += d.segment<2>(first_shared);
    for (std::size_t i = 0; i < state.frames.size(); ++i) {
        const Eigen::Vector3d own = d.segment<3>(of_frame(i));
        Pose2& pose = state.frames[i].pose;
        pose = {pose.x + own.x(), pose.y + own.y(), wrap_angle(pose.yaw + own.z())};
    }
    return d.head<first_frame>().norm();
}

double rms_from_centre(const State& state) {
    double squares = 0;
    for (const MountFrame& frame : state.frames) squares += (Eigen::Vector2d(frame.pose.x, frame.pose.y) - state.shared).squaredNorm();
    return std::sqrt(squares / (2 * std::max<double>(1, static_cast<double>(state.frames.size()) - 2)));
}

/// Gauss-Newton to the end. An error if a landmark would be out of view.
Result<Equations> solve(State& state, const Eigen::Isometry3d& start, const MountSettings& settings) {
    const Error lost{"the mount in the site file is too far off: a landmark would be out of view; correct its quaternion by hand first"};
    Eigen::SimplicialLDLT<Sparse> solver;
    for (int round = 0; round < 30; ++round) {
        const auto equations = equations_of(state, start, settings);
        if (!equations) return lost;
        solver.compute(equations->information());
        const Eigen::VectorXd d = solver.solve(equations->gradient);
        if (solver.info() != Eigen::Success || !d.allFinite()) return Error{"what these frames show does not fix the robot's poses: record more landmarks"};
        const double change = move(state, d);
        bool settled = true;
        if (!state.with_wheels()) {
            const double seen = std::clamp(rms_from_centre(state), 2e-4, most_wobble);
            settled = std::abs(seen - state.spot_sigma) < 0.02 * state.spot_sigma;
            state.spot_sigma = seen;
        }
        if (change < 1e-9 && settled) break;
    }
    if (!state.with_wheels() && state.spot_sigma >= most_wobble) {
        return Error{"the robot did not keep to one spot: let it turn on the spot, or record its odometry, too"};
    }
    auto equations = equations_of(state, start, settings);
    if (!equations) return lost;
    return std::move(*equations);
}

/// The part of the circle that the headings cover: all of it but the largest gap, rad.
double covered_angle(const std::vector<MountFrame>& frames) {
    std::vector<double> headings;
    for (const MountFrame& frame : frames) headings.push_back(frame.pose.yaw);
    std::sort(headings.begin(), headings.end());
    double gap = headings.front() + 2 * std::numbers::pi - headings.back();
    for (std::size_t i = 1; i < headings.size(); ++i) gap = std::max(gap, headings[i] - headings[i - 1]);
    return 2 * std::numbers::pi - gap;
}

/// How far off a level camera's fixes would be because of the mount's error `d`, at a rise (m) above it: robot frame, linear.
Eigen::Matrix<double, 2, 6> offset_jacobian(double rise) {
    Eigen::Matrix<double, 2, 6> j = Eigen::Matrix<double, 2, 6>::Zero();
    j(0, 0) = j(1, 1) = 1;
    j(0, 4) = rise;  // a turn about y moves what is above along x
    j(1, 3) = -rise;
    return j;
}

/// Steps between neighbouring frames; empty where the wheels are silent for most of them.
std::vector<std::optional<OdometryStep>> steps_between(const std::vector<MountFrame>& frames, const OdometryTrack& wheels) {
    std::vector<std::optional<OdometryStep>> steps(frames.size());
    std::size_t known = 0;
    for (std::size_t i = 1; i < frames.size(); ++i) {
        if (frames[i].time > frames[i - 1].time) steps[i] = wheels.step(frames[i - 1].time, frames[i].time);
        known += steps[i].has_value();
    }
    if (2 * known < frames.size()) steps.clear();
    return steps;
}

/// Mean square of a frame's points over their variances.
double misfit(const State& state, const MountFrame& frame) {
    double sum = 0;
    for (const SeenPoint& point : frame.points) {
        const auto pixel = predict_point(state.camera, frame.pose, point.map);
        if (!pixel) return 1e9;
        const Eigen::Vector2d off = point.pixel - *pixel;
        sum += off.dot(point.covariance.inverse() * off) / (2 * static_cast<double>(frame.points.size()));
    }
    return sum;
}

/// Drops frames that fit far worse than most: their landmark is another one, or not one at all.
std::size_t drop_outliers(State& state, const OdometryTrack& wheels, double gate) {
    std::vector<double> misfits;
    for (const MountFrame& frame : state.frames) misfits.push_back(misfit(state, frame));
    std::vector<double> sorted = misfits;
    const double most = gate * gate * std::max(median(sorted), 1.0);
    std::size_t i = 0;
    const std::size_t dropped = std::erase_if(state.frames, [&](const MountFrame&) { return misfits[i++] > most; });
    if (dropped > 0 && state.with_wheels()) state.driven = steps_between(state.frames, wheels);
    return dropped;
}

/// What the errors that all frames share do to the mount: those of each landmark's points, of the given sigma (they do not average
/// out), and those of the intrinsics.
struct Systematic {
    Matrix6d by_points = Matrix6d::Zero();  // covariance
    PoseByIntrinsics by_intrinsics = PoseByIntrinsics::Zero();
};
Systematic systematic_of(const State& state, const Eigen::MatrixXd& columns, double point_sigma) {
    Systematic result;
    std::vector<std::pair<Eigen::Vector3d, Eigen::Matrix<double, 6, 3>>> effects;
    const auto effect_of = [&](const Eigen::Vector3d& point) -> Eigen::Matrix<double, 6, 3>& {
        for (auto& [known, effect] : effects) {
            if (known == point) return effect;
        }
        return effects.emplace_back(point, Eigen::Matrix<double, 6, 3>::Zero()).second;
    };
    for (std::size_t i = 0; i < state.frames.size(); ++i) {
        for (const SeenPoint& point : state.frames[i].points) {
            SeenPointJacobian j;
            if (!predict_point(state.camera, state.frames[i].pose, point.map, &j)) continue;
            const Eigen::Matrix<double, 6, 2> gain =
                (columns.topRows<6>().transpose() * j.by_mount.transpose() + columns.middleRows<3>(of_frame(i)).transpose() * j.by_pose.transpose()) *
                point.covariance.inverse();
            effect_of(point.map) -= gain * j.by_point;
            result.by_intrinsics -= gain * j.by_intrinsics;
        }
    }
    for (const auto& [point, effect] : effects) result.by_points += point_sigma * point_sigma * effect * effect.transpose();
    return result;
}

std::vector<std::string> not_observed(const Matrix6d& covariance, const Vector6d& prior) {
    const char* const names[] = {"its place along the robot's x", "its place along the robot's y", "its height", "its tilt about x", "its tilt about y",
                                 "its turn about the vertical"};
    std::vector<std::string> result;
    for (int i = 0; i < 6; ++i) {
        if (covariance(i, i) > 0.7 * prior[i] * prior[i]) result.emplace_back(names[i]);
    }
    return result;
}

/// Does the session show enough?
Result<void> enough_motion(const State& state, const MountSettings& settings, MountCalibration& result) {
    result.turned = covered_angle(state.frames);
    result.with_wheels = state.with_wheels();
    for (const auto& step : state.driven) result.driven += step ? step->way.norm() : 0;
    if (!state.with_wheels() && result.turned < settings.least_turn) {
        return Error{
            fmt::format("the robot turned through {:.0f} deg only: let it make a full turn on the spot, or record its odometry, too, and let it turn and drive",
                        degrees(result.turned))};
    }
    if (state.with_wheels() && result.turned < settings.least_drive_turn && result.driven < settings.least_drive) {
        return Error{
            fmt::format("the robot hardly moved ({:.0f} deg, {:.2f} m): let it turn and drive below the landmarks", degrees(result.turned), result.driven)};
    }
    return {};
}

}  // namespace

Result<MountCalibration> calibrate_mount(const CameraOnRobot& start, std::vector<MountFrame> frames, const MountSettings& settings,
                                         const OdometryTrack& wheels) {
    std::erase_if(frames, [](const MountFrame& f) { return f.points.empty(); });
    const auto too_few = [&](std::size_t count) {
        return Error{fmt::format("only {} pictures show a landmark, {} are needed: let the robot turn below one", count, settings.least_frames)};
    };
    if (static_cast<int>(frames.size()) < settings.least_frames) return too_few(frames.size());
    State state{start, Eigen::Vector2d::Zero(), std::move(frames), {}};
    state.driven = steps_between(state.frames, wheels);
    MountCalibration result;
    if (auto enough = enough_motion(state, settings, result); !enough) return enough.error();
    if (!state.with_wheels()) {
        for (const MountFrame& frame : state.frames) state.shared += Eigen::Vector2d(frame.pose.x, frame.pose.y) / static_cast<double>(state.frames.size());
    }
    const Eigen::Isometry3d before = start.robot_from_camera.pose;
    auto equations = solve(state, before, settings);
    if (!equations) return equations.error();
    for (int round = 0; round < 3; ++round) {
        const std::size_t dropped = drop_outliers(state, wheels, settings.outlier);
        if (dropped == 0) break;
        result.refused += static_cast<int>(dropped);
        if (static_cast<int>(state.frames.size()) < settings.least_frames) return too_few(state.frames.size());
        equations = solve(state, before, settings);
        if (!equations) return equations.error();
    }
    const Eigen::SimplicialLDLT<Sparse> solver(equations->information());
    const Eigen::MatrixXd columns = solver.solve(Eigen::MatrixXd::Identity(equations->gradient.size(), 6));
    const Systematic systematic = systematic_of(state, columns, settings.point_sigma);
    const Eigen::Isometry3d& found = state.camera.robot_from_camera.pose;
    const Matrix6d covariance = 0.5 * (columns.topRows<6>() + columns.topRows<6>().transpose()) + systematic.by_points;
    result.robot_from_camera = {found, covariance};
    result.by_intrinsics = systematic.by_intrinsics;
    result.frames = static_cast<int>(state.frames.size());
    result.spot_sigma = state.spot_sigma;
    if (state.with_wheels()) {
        result.wheel_scale = state.shared[0];
        result.wheel_drift = state.shared[1];
    }
    result.pixel_rms = std::sqrt(equations->pixel_squares / equations->pixels);
    const Eigen::Vector3d axis = found.linear().col(2);
    result.tilt = std::atan2(axis.head<2>().norm(), std::abs(axis.z()));
    const Matrix6d all = covariance + result.by_intrinsics * start.intrinsics.covariance * result.by_intrinsics.transpose();
    result.tilt_sigma = std::sqrt(std::max(all(3, 3), all(4, 4)));
    const double rise = state.frames[0].points.back().map.z() - found.translation().z();
    result.offset = (offset_jacobian(rise) * error_between(before, found)).norm();
    result.not_observed = not_observed(covariance, prior_sigmas(settings));
    return result;
}

double tilt_error(const Matrix6d& robot_from_camera) {
    constexpr double rise = 2.5;  // m
    return rise * std::sqrt(robot_from_camera(3, 3) + robot_from_camera(4, 4));
}

}  // namespace roomfix
