// What is believed of one robot: mean and covariance of its state.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <optional>

#include "roomfix/base/fixed_list.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

/// The first states of every robot. Pose and velocity in the map (m, rad, m/s, rad/s); of the odometry: true way = (1 + scale) * measured
/// way, true turning = (1 + turn_scale) * measured turning + drift * time (rad/s).
enum CoreState : int { state_x, state_y, state_yaw, state_vx, state_vy, state_turn, state_scale, state_turn_scale, state_drift, core_states };
constexpr int most_slow_states = 56;
constexpr int most_states = core_states + most_slow_states;

/// Errors of sensors that change slowly and are estimated along with the robot.
enum class SlowKind : std::uint8_t {
    range_bias,       // m, of one beacon, `component` is its index; -1: of all beacons alike; `source` is the receiver, or the detector
    range_wander,     // m, of one beacon, what changes with the place; as before
    range_scale,      // how much longer all ranges are than the way, as a part of it
    range_direction,  // part of the range: times cos(bearing) - 1 (`component` 0) or times sin(bearing) (1)
    range_curve,      // 1/m, times the range squared: how much longer ranges are
    bearing_shape,    // rad, of a detector's bearings: times sin(bearing) (`component` 0), 1 - cos(bearing) (1), sin(2 bearing) (2)
    bearing_bias,     // rad, of a detector's bearings to all landmarks alike
    bearing_wander,   // rad, likewise, what changes with the place
    receiver_place,   // m, along one of the robot's axes, which `component` is; `source` is the receiver
    time_offset,      // 1, how much later than stated a camera's pictures were taken, in standard deviations; `component` is the way their times are told
    calibration,      // 1, of a camera's pose in the map or on the robot: six, in units of standard deviations
    body,             // 1, of what a robot's description leaves out: three, in units of standard deviations, for each camera that may show it alone
    landmark_place,   // 1, of a landmark's position: x, y, z, in units of its standard deviation; `source` is its index
    corner_place,     // 1, of a corner's position: three, in units of its standard deviation; `source` is its index
};

/// Gauss-Markov: it stays as it is over a short time, and forgets its value over a long one.
struct SlowState {
    SlowKind kind = SlowKind::range_bias;
    int source = 0;  // of the tracker's sources
    int component = 0;
    double variance = 1;    // of its value when nothing is known
    double per_second = 0;  // 1 / s, how fast it forgets
    double per_metre = 0;   // 1 / m, the same along the robot's way
};

using StateVector = Eigen::Matrix<double, most_states, 1>;
using StateMatrix = Eigen::Matrix<double, most_states, most_states>;

/// Only the first `size` rows and columns mean something, and only they are copied.
struct Belief {
    int size = core_states;
    StateVector mean;
    StateMatrix covariance;
    FixedList<SlowState, most_slow_states> slow;

    Belief() {
        mean.setZero();
        covariance.topLeftCorner<core_states, core_states>().setZero();
    }
    Belief(const Belief& other) { *this = other; }
    Belief& operator=(const Belief& other) {
        size = other.size;
        slow = other.slow;
        mean.head(size) = other.mean.head(size);
        covariance.topLeftCorner(size, size) = other.covariance.topLeftCorner(size, size);
        return *this;
    }

    Pose2 pose() const { return {mean[state_x], mean[state_y], mean[state_yaw]}; }
    Eigen::Vector3d velocity() const { return mean.segment<3>(state_vx); }  // m/s, m/s, rad/s
    Eigen::Matrix3d pose_covariance() const { return covariance.topLeftCorner<3, 3>(); }
    /// Standard deviation of the place, both directions together, m.
    double place_sigma() const { return std::sqrt(covariance(0, 0) + covariance(1, 1)); }
    /// How fast it drives towards where it looks, m/s.
    double forward_speed() const { return std::cos(mean[state_yaw]) * mean[state_vx] + std::sin(mean[state_yaw]) * mean[state_vy]; }
    /// Known well enough for a front and a back to have a meaning.
    bool yaw_known() const { return covariance(state_yaw, state_yaw) < 0.5 * 0.5; }
};

/// Standard deviation of a place in its worst direction, m.
double worst_sigma(const Eigen::Matrix2d& covariance);

/// Variance of a yaw that nobody knows, rad^2: of the uniform distribution over a turn.
constexpr double unknown_yaw_variance = std::numbers::pi * std::numbers::pi / 3;

/// How well the robot's odometry is known before anything was seen of it.
struct OdometryPrior {
    double scale_sigma = 0.02;
    double turn_scale_sigma = 0.02;
    double drift_sigma = 0.01;  // rad/s
};

/// A robot at rest at a pose, as far as known: `speed_sigma` m/s, `turn_sigma` rad/s.
Belief belief_at(const Pose2& pose, const Eigen::Matrix3d& covariance, double speed_sigma, double turn_sigma, const OdometryPrior& prior);

/// Index of a slow state in the state vector; nothing if the belief has none such.
std::optional<int> find_slow(const Belief& belief, SlowKind kind, int source, int component);

/// Index of a slow state, added with its prior if it is not there. Where there is no room, the slow state that is closest to its prior
/// makes some.
int ensure_slow(Belief& belief, const SlowState& state);

/// Lets slow states forget over a time (s) and a way (m).
void forget_slow(Belief& belief, double seconds, double metres);

}  // namespace roomfix
