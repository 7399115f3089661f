#include "roomfix/estimate/motion.hpp"

#include <cmath>

namespace roomfix {
namespace {

constexpr int moving = 6;  // states that a prediction changes: pose and velocity

using Transition = Eigen::Matrix<double, moving, core_states>;

Eigen::Matrix2d rotation(double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    Eigen::Matrix2d r;
    r << c, -s, s, c;
    return r;
}

/// The vector turned by 90 degrees: the derivative of a rotated vector by the angle.
Eigen::Vector2d turned(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// P <- F P F^T + Q; F is the identity beyond the rows of `f`.
void propagate(Belief& belief, const Transition& f, const Eigen::Matrix<double, moving, moving>& noise) {
    auto& p = belief.covariance;
    const Eigen::Matrix<double, moving, core_states> core = f * p.topLeftCorner<core_states, core_states>();
    p.topLeftCorner<moving, moving>() = core * f.transpose() + noise;
    for (int j = 0; j < moving; ++j) {
        for (int i = 0; i < j; ++i) p(j, i) = p(i, j);
    }
    p.block<moving, core_states - moving>(0, moving) = core.rightCols<core_states - moving>();
    p.block<core_states - moving, moving>(moving, 0) = core.rightCols<core_states - moving>().transpose();
    for (int slow = core_states; slow < belief.size; ++slow) {
        const Eigen::Matrix<double, moving, 1> column = f * p.block<core_states, 1>(0, slow);
        p.block<moving, 1>(0, slow) = column;
        p.block<1, moving>(slow, 0) = column.transpose();
    }
}

}  // namespace

void predict(Belief& belief, double seconds, const MotionModel& model) {
    if (seconds <= 0) return;
    const double dt = seconds;
    const double yaw = belief.mean[state_yaw];
    const double turn = belief.mean[state_turn];
    const Eigen::Vector2d velocity = belief.mean.segment<2>(state_vx);
    const double keep = std::exp(-dt / model.memory);
    Transition f = Transition::Zero();
    f.leftCols<moving>().setIdentity();

    // A differential drive turns its velocity with itself and soon loses what goes across its wheels.
    const bool steers = model.drive == Drive::differential && belief.yaw_known();
    Eigen::Vector2d next = keep * velocity;
    Eigen::Matrix2d by_velocity = keep * Eigen::Matrix2d::Identity();
    Eigen::Vector2d by_yaw = Eigen::Vector2d::Zero();
    Eigen::Vector2d by_turn = Eigen::Vector2d::Zero();
    Eigen::Matrix2d axes = Eigen::Matrix2d::Identity();
    double across = model.acceleration;
    if (steers) {
        across = model.side_acceleration;
        axes = rotation(yaw);
        const Eigen::Matrix2d new_axes = rotation(yaw + turn * dt);
        const Eigen::DiagonalMatrix<double, 2> fade(keep, keep * std::exp(-dt / model.slip_memory));
        const Eigen::Vector2d own = axes.transpose() * velocity;
        const Eigen::Vector2d faded = fade * own;
        next = new_axes * faded;
        by_velocity = new_axes * fade * axes.transpose();
        by_turn = dt * turned(next);
        by_yaw = turned(next) - new_axes * (fade * turned(own));
    }
    belief.mean.head<2>() += 0.5 * dt * (velocity + next);
    belief.mean[state_yaw] += turn * dt;
    belief.mean.segment<2>(state_vx) = next;
    belief.mean[state_turn] = keep * turn;
    f.block<2, 2>(state_vx, state_vx) = by_velocity;
    f.block<2, 1>(state_vx, state_yaw) = by_yaw;
    f.block<2, 1>(state_vx, state_turn) = by_turn;
    f.block<2, 2>(state_x, state_vx) = 0.5 * dt * (Eigen::Matrix2d::Identity() + by_velocity);
    f.block<2, 1>(state_x, state_yaw) = 0.5 * dt * by_yaw;
    f.block<2, 1>(state_x, state_turn) = 0.5 * dt * by_turn;
    f(state_yaw, state_turn) = dt;
    f(state_turn, state_turn) = keep;

    const Eigen::Vector2d spread(model.acceleration * model.acceleration, across * across);
    const Eigen::Matrix2d push = axes * spread.asDiagonal() * axes.transpose();
    const double twist = model.turning * model.turning;
    Eigen::Matrix<double, moving, moving> noise = Eigen::Matrix<double, moving, moving>::Zero();
    noise.block<2, 2>(state_x, state_x) = dt * dt * dt / 3 * push;
    noise.block<2, 2>(state_x, state_vx) = noise.block<2, 2>(state_vx, state_x) = dt * dt / 2 * push;
    noise.block<2, 2>(state_vx, state_vx) = dt * push;
    noise(state_yaw, state_yaw) = dt * dt * dt / 3 * twist;
    noise(state_yaw, state_turn) = noise(state_turn, state_yaw) = dt * dt / 2 * twist;
    noise(state_turn, state_turn) = dt * twist;
    propagate(belief, f, noise);
    forget_slow(belief, dt, dt * velocity.norm());
}

void predict(Belief& belief, const OdometryStep& step, const OdometryNoise& noise) {
    const double dt = step.seconds;
    if (dt <= 0) return;
    const double yaw = belief.mean[state_yaw];
    const double scale = 1 + belief.mean[state_scale];
    const double turn_scale = belief.mean[state_turn_scale];
    const double drift = belief.mean[state_drift];
    const double missing = turn_scale * step.turned + drift * dt;  // rad, that the wheels do not know of
    const Eigen::Matrix2d axes = rotation(yaw + 0.5 * missing);
    const Eigen::Vector2d way = axes * step.way;
    const double new_yaw = yaw + step.turned + missing;
    const Eigen::Vector2d velocity = rotation(new_yaw) * step.velocity;

    belief.mean.head<2>() += scale * way;
    belief.mean[state_yaw] = new_yaw;
    belief.mean.segment<2>(state_vx) = scale * velocity;
    belief.mean[state_turn] = (1 + turn_scale) * step.turn_rate + drift;

    Transition f = Transition::Zero();
    f.topLeftCorner<3, 3>().setIdentity();
    f.block<2, 1>(state_x, state_yaw) = scale * turned(way);
    f.block<2, 1>(state_x, state_scale) = way;
    f.block<2, 1>(state_x, state_turn_scale) = 0.5 * step.turned * scale * turned(way);
    f.block<2, 1>(state_x, state_drift) = 0.5 * dt * scale * turned(way);
    f(state_yaw, state_turn_scale) = step.turned;
    f(state_yaw, state_drift) = dt;
    f.block<2, 1>(state_vx, state_yaw) = scale * turned(velocity);
    f.block<2, 1>(state_vx, state_scale) = velocity;
    f.block<2, 1>(state_vx, state_turn_scale) = step.turned * scale * turned(velocity);
    f.block<2, 1>(state_vx, state_drift) = dt * scale * turned(velocity);
    f(state_turn, state_turn_scale) = step.turn_rate;
    f(state_turn, state_drift) = 1;

    const double length = step.way.norm();
    const double at_rest = noise.still * noise.still * dt;
    const Eigen::Vector2d spread(noise.along * noise.along * length + at_rest, noise.across * noise.across * length + at_rest);
    Eigen::Matrix<double, moving, moving> q = Eigen::Matrix<double, moving, moving>::Zero();
    q.block<2, 2>(state_x, state_x) = axes * spread.asDiagonal() * axes.transpose();
    q(state_yaw, state_yaw) = noise.turn_per_metre * noise.turn_per_metre * length + noise.turn_per_radian * noise.turn_per_radian * std::abs(step.turned) +
                              noise.still_turn * noise.still_turn * dt;
    q(state_vx, state_vx) = q(state_vy, state_vy) = noise.velocity * noise.velocity;
    q(state_turn, state_turn) = noise.turn_rate * noise.turn_rate;
    propagate(belief, f, q);
    belief.covariance(state_scale, state_scale) += noise.scale_walk * noise.scale_walk * dt;
    belief.covariance(state_turn_scale, state_turn_scale) += noise.scale_walk * noise.scale_walk * dt;
    belief.covariance(state_drift, state_drift) += noise.drift_walk * noise.drift_walk * dt;
    forget_slow(belief, dt, length);
}

}  // namespace roomfix
