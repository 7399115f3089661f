#include "roomfix/estimate/pose_model.hpp"

#include <numbers>

#include "roomfix/estimate/time_error_model.hpp"

namespace roomfix {
namespace {

using ByCalibration = Eigen::Matrix<double, 3, 6>;

/// How the pose moves with the unit-normal errors of the calibration. Errors that are lost in the noise need no states.
std::optional<ByCalibration> by_calibration(const PoseObservation& observation, const PoseSource& source) {
    const ByCalibration& by = observation.by_calibration;
    if (source.calibrated_exactly || by.squaredNorm() < 0.01 * observation.covariance.trace()) return std::nullopt;
    return by;
}

/// The slow state of one of the three errors that last.
int component_of(const LastingError& lasting, int error) { return 3 * (lasting.only_camera + 1) + error; }

}  // namespace

Pose2 moved(const Belief& belief, double seconds) {
    const Pose2 pose = belief.pose();
    const Eigen::Vector3d way = seconds * belief.velocity();
    return {pose.x + way.x(), pose.y + way.y(), pose.yaw + way.z()};
}

void add_slow_states(Belief& belief, const PoseSource& source, const TimeError& error) {
    add_time_error(belief, source.source, source.time_offset_sigma, error);
    for (int i = 0; i < 6 && !source.calibrated_exactly; ++i) {
        ensure_slow(belief, {SlowKind::calibration, source.source, i, 1, 1 / source.calibration_memory});
    }
}

void add_slow_states(Belief& belief, const PoseObservation& observation, const PoseSource& source) {
    PoseSource known = source;
    if (!by_calibration(observation, source)) known.calibrated_exactly = true;
    add_slow_states(belief, known, observation.time_error);
    for (int i = 0; i < 3; ++i) {
        if (observation.lasting.root.col(i).isZero(0)) continue;
        ensure_slow(belief, {SlowKind::body, source.source, component_of(observation.lasting, i), 1, 1 / source.body_memory});
    }
}

Linearised<3> linearise_pose(const Belief& belief, const PoseObservation& observation, const PoseSource& source) {
    Linearised<3> l;
    const Pose2 pose = moved(belief, observation.late);
    const double turn = 2 * std::numbers::pi / std::max(observation.like_turns, 1);
    l.residual = Eigen::Vector3d(observation.pose.x - pose.x, observation.pose.y - pose.y, std::remainder(observation.pose.yaw - pose.yaw, turn));
    l.noise = observation.covariance;
    for (int i = 0; i < 3; ++i) l.depends(i, Eigen::Vector3d::Unit(i));
    for (int i = 0; i < 3 && observation.late != 0; ++i) l.depends(state_vx + i, observation.late * Eigen::Vector3d::Unit(i));
    depends_on_time<3>(l, belief, source.source, source.time_offset_sigma, observation.time_error, belief.velocity());
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d column = observation.lasting.root.col(i);
        const auto slow = find_slow(belief, SlowKind::body, source.source, component_of(observation.lasting, i));
        if (!slow || column.isZero(0)) continue;
        l.noise -= column * column.transpose();
        l.depends_on_slow(belief, *slow, column);
    }
    if (const auto by = by_calibration(observation, source)) {
        for (int i = 0; i < 6; ++i) {
            const auto slow = find_slow(belief, SlowKind::calibration, source.source, i);
            if (!slow) continue;
            l.noise -= by->col(i) * by->col(i).transpose();
            l.depends_on_slow(belief, *slow, by->col(i));
        }
    }
    return l;
}

Linearised<2> linearise_place(const Belief& belief, const PoseObservation& observation, const PoseSource& source) {
    const Linearised<3> whole = linearise_pose(belief, observation, source);
    Linearised<2> l;
    l.residual = whole.residual.head<2>();
    l.noise = whole.noise.topLeftCorner<2, 2>();
    for (std::size_t k = 0; k < whole.states.size(); ++k) l.depends(whole.states[k], whole.by_state.col(static_cast<Eigen::Index>(k)).head<2>());
    return l;
}

}  // namespace roomfix
