#include "roomfix/estimate/range_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "roomfix/estimate/sighting_model.hpp"

namespace roomfix {
namespace {

/// Past this part of the distance, the belief's spread bends the circle around the beacon enough to matter.
constexpr double flat = 0.03;

constexpr int all_beacons = -1;  // component of the bias that they have in common
constexpr int any_receiver = 0;  // source of the bias of a beacon: its own clock and aerial, whatever receiver hears it

Innovation surprise_of(const LatePosterior& posterior) { return {posterior.log_evidence, posterior.on_time, posterior.nis, 1}; }

/// Updates at the belief's mean; where it bends, once more linearised at where that led.
template <class Predict, class Measure>
Innovation update_twice(Belief& belief, double distance, const Predict& predict, const Measure& measure) {
    const auto once = [&](Belief& taken, const Pose2& at) {
        const Pose2 pose = taken.pose();
        const PredictedValue there = predict(taken, at);
        const auto& by = there.by_state;
        const double predicted = there.value + by[0] * (pose.x - at.x) + by[1] * (pose.y - at.y) + by[2] * (pose.yaw - at.yaw);
        return update_scalar(taken, predicted, there.states, by, measure);
    };
    if (belief.place_sigma() < flat * distance) return surprise_of(once(belief, belief.pose()));
    Belief tried = belief;
    once(tried, belief.pose());
    return surprise_of(once(belief, tried.pose()));
}

/// The receiver's place on the robot. While nobody knows where the front is, it is the receiver that is tracked, and no range tells
/// the yaw.
Eigen::Vector3d arm_of(const Belief& belief, const RangeSource& source) {
    return belief.yaw_known() ? source.receiver : Eigen::Vector3d(0, 0, source.receiver.z());
}

}  // namespace

PredictedRange predict_range(const Pose2& pose, const Eigen::Vector3d& receiver, const Eigen::Vector3d& beacon) {
    const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
    const Eigen::Vector2d arm(c * receiver.x() - s * receiver.y(), s * receiver.x() + c * receiver.y());
    const Eigen::Vector3d way(pose.x + arm.x() - beacon.x(), pose.y + arm.y() - beacon.y(), receiver.z() - beacon.z());
    const double range = std::max(way.norm(), 1e-6);
    return {range, {way.x() / range, way.y() / range, (way.y() * arm.x() - way.x() * arm.y()) / range}};
}

RangeSource learned(RangeSource source, const RangeErrors& errors) {
    source.factor *= errors.factor;
    source.bias_sigma = std::max(source.bias_sigma, errors.common);
    source.own_sigma = std::max(source.own_sigma, errors.own);
    const double scale = std::max(source.stretch.scale, errors.stretch.scale);
    source.stretch = errors.stretch;
    source.stretch.scale = scale;
    source.wander_sigma = errors.wander;
    source.sway_sigma = errors.sway;
    source.wander_way *= errors.way;
    return source;
}

void add_slow_states(Belief& belief, int beacon, const RangeSource& source) {
    const double forget = 1 / source.bias_memory;
    const auto squared = [](double v) { return v * v; };
    if (source.bias_sigma > 0) ensure_slow(belief, {SlowKind::range_bias, source.number, all_beacons, squared(source.bias_sigma), forget});
    if (source.own_sigma > 0) ensure_slow(belief, {SlowKind::range_bias, any_receiver, beacon, squared(source.own_sigma), forget});
    if (source.wander_sigma > 0) ensure_slow(belief, {SlowKind::range_wander, source.number, beacon, squared(source.wander_sigma), 0, 1 / source.wander_way});
    if (source.sway_sigma > 0) ensure_slow(belief, {SlowKind::range_wander, source.number, all_beacons, squared(source.sway_sigma), 0, 1 / source.wander_way});
    add_slow_states(belief, source.number, source.stretch, forget);
    for (int axis = 0; axis < 3; ++axis) {
        if (source.receiver_sigma[axis] > 0) ensure_slow(belief, {SlowKind::receiver_place, source.number, axis, squared(source.receiver_sigma[axis])});
    }
}

PredictedValue predict_measured_range(const Belief& belief, const Pose2& at, int beacon, const Eigen::Vector3d& position, const RangeSource& source) {
    Eigen::Vector3d arm = arm_of(belief, source);
    std::array<std::optional<int>, 3> places;
    if (!source.receiver_sigma.isZero(0)) {
        for (int axis = belief.yaw_known() ? 0 : 2; axis < 3; ++axis) {
            places[static_cast<std::size_t>(axis)] = find_slow(belief, SlowKind::receiver_place, source.number, axis);
            if (const auto& place = places[static_cast<std::size_t>(axis)]) arm[axis] += belief.mean[*place];
        }
    }
    const PredictedRange exact = predict_range(at, arm, position);
    PredictedValue predicted;
    const auto depends = [&](int state, double derivative) {
        predicted.by_state[static_cast<Eigen::Index>(predicted.states.size())] = derivative;
        predicted.states.push_back(state);
    };
    // Where nothing depends on the direction, none is needed.
    const bool directed = source.stretch.depth != 0 || source.stretch.direction > 0;
    const PredictedSighting seen = directed ? predict_sighting(at, arm.head<2>(), position.head<2>()) : PredictedSighting{};
    const StretchedRange stated = stretched(belief, source.number, source.stretch, exact.range, seen.bearing);
    predicted.value = stated.value;
    for (int i = 0; i < 3; ++i) depends(i, stated.by_range * exact.by_pose[i] + stated.by_bearing * seen.bearing_by_pose[i]);
    for (std::size_t i = 0; i < stated.states.size(); ++i) depends(stated.states[i], stated.by_state[i]);
    const auto add_bias = [&](SlowKind kind, int receiver, int component) {
        const auto bias = find_slow(belief, kind, receiver, component);
        if (!bias) return;
        depends(*bias, 1);
        predicted.value += belief.mean[*bias];
    };
    add_bias(SlowKind::range_bias, source.number, all_beacons);
    add_bias(SlowKind::range_bias, any_receiver, beacon);
    add_bias(SlowKind::range_wander, source.number, beacon);
    add_bias(SlowKind::range_wander, source.number, all_beacons);
    const double c = std::cos(at.yaw), s = std::sin(at.yaw);
    const Eigen::Vector3d by_arm(c * exact.by_pose.x() + s * exact.by_pose.y(), -s * exact.by_pose.x() + c * exact.by_pose.y(),
                                 (arm.z() - position.z()) / exact.range);
    const Eigen::Vector3d& turning = seen.bearing_by_pose;
    const Eigen::Vector3d bearing_by_arm(c * turning.x() + s * turning.y(), -s * turning.x() + c * turning.y(), 0);
    const Eigen::Vector3d value_by_arm = stated.by_range * by_arm + stated.by_bearing * bearing_by_arm;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (places[axis]) depends(*places[axis], value_by_arm[static_cast<Eigen::Index>(axis)]);
    }
    return predicted;
}

PredictedValue predict_difference(const Belief& belief, const Pose2& at, const Eigen::Vector3d& first, const Eigen::Vector3d& second,
                                  const RangeSource& source) {
    const Eigen::Vector3d arm = arm_of(belief, source);
    const PredictedRange a = predict_range(at, arm, first);
    const PredictedRange b = predict_range(at, arm, second);
    PredictedValue predicted;
    predicted.value = b.range - a.range;
    for (int i = 0; i < 3; ++i) predicted.states.push_back(i);
    predicted.by_state.head<3>() = (b.by_pose - a.by_pose).transpose();
    return predicted;
}

Innovation update_range(Belief& belief, const RangeObservation& observation, const Eigen::Vector3d& beacon, const RangeSource& source) {
    add_slow_states(belief, observation.beacon, source);
    const auto predict = [&](const Belief& taken, const Pose2& at) { return predict_measured_range(taken, at, observation.beacon, beacon, source); };
    const double sigma = grown(source.factor * observation.sigma, source.stretch, observation.range);
    const auto measure = [&](const Gaussian1& prior) { return measure_range(prior, observation.range, sigma, source.late); };
    return update_twice(belief, observation.range, predict, measure);
}

Innovation update_difference(Belief& belief, const RangeDifferenceObservation& observation, const Eigen::Vector3d& first, const Eigen::Vector3d& second,
                             const RangeSource& source) {
    const auto predict = [&](const Belief& taken, const Pose2& at) { return predict_difference(taken, at, first, second, source); };
    const Pose2 pose = belief.pose();
    const double nearest = std::min(predict_range(pose, source.receiver, first).range, predict_range(pose, source.receiver, second).range);
    const auto measure = [&](const Gaussian1& prior) {
        return measure_difference(prior, observation.difference, source.factor * observation.sigma, source.late);
    };
    return update_twice(belief, nearest, predict, measure);
}

}  // namespace roomfix
