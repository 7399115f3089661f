#include "roomfix/estimate/sighting_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "roomfix/estimate/late_range.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {
namespace {

constexpr int all_landmarks = -1;
constexpr double farthest = 20;  // m: over that range, and all around, sightings of nothing are spread
constexpr double gate = 16;      // squared distance at which a sighting and an outlier are equally likely

using Column = Eigen::Vector2d;

int rows_of(const SightingObservation& seen) { return static_cast<int>(seen.range.has_value()) + static_cast<int>(seen.bearing.has_value()); }

/// Log density of an outlier over all that the sighting could have been.
double log_anywhere(const SightingObservation& seen) { return -(seen.range ? std::log(farthest) : 0) - (seen.bearing ? std::log(2 * std::numbers::pi) : 0); }

constexpr int bearing_shapes = 3;

/// What a bearing is stated too large by, as a lens or a scanner bends it, and its derivatives.
struct BearingShape {
    double value = 0;                               // rad
    double by_bearing = 1;                          // of the stated bearing
    FixedList<int, bearing_shapes> states;          // slow states that it depends on ...
    std::array<double, bearing_shapes> by_state{};  // ... and how

    BearingShape(const Belief& belief, const DetectorSource& source, double bearing) {
        if (!(source.bearing_shape > 0)) return;
        const std::array<double, bearing_shapes> shapes = {std::sin(bearing), 1 - std::cos(bearing), std::sin(2 * bearing)};
        const std::array<double, bearing_shapes> slopes = {std::cos(bearing), std::sin(bearing), 2 * std::cos(2 * bearing)};
        for (int component = 0; component < bearing_shapes; ++component) {
            const auto state = find_slow(belief, SlowKind::bearing_shape, of_detector, component);
            if (!state) continue;
            const auto k = static_cast<std::size_t>(component);
            value += belief.mean[*state] * shapes[k];
            by_bearing += belief.mean[*state] * slopes[k];
            by_state[states.size()] = shapes[k];
            states.push_back(*state);
        }
    }
};

/// Innovation's covariance, of the rows that were seen.
Eigen::Matrix2d innovation_of(const Belief& belief, const Linearised<2>& l) {
    Eigen::Matrix2d s = l.noise;
    for (std::size_t a = 0; a < l.states.size(); ++a) {
        Column sum = Column::Zero();
        for (std::size_t b = 0; b < l.states.size(); ++b) sum += belief.covariance(l.states[a], l.states[b]) * l.by_state.col(static_cast<Eigen::Index>(b));
        s += l.by_state.col(static_cast<Eigen::Index>(a)) * sum.transpose();
    }
    return s;
}

/// Log density of what was seen: the bearing's, and the range's where the bearing is what it is.
double log_likelihood(const Belief& belief, const SightingObservation& seen, const Linearised<2>& l, const DetectorSource& source) {
    const Eigen::Matrix2d s = innovation_of(belief, l);
    double log = 0, expected = 0, variance = s(0, 0);
    if (seen.bearing) {
        log -= 0.5 * (l.residual.y() * l.residual.y() / s(1, 1) + std::log(2 * std::numbers::pi * s(1, 1)));
        expected = s(0, 1) / s(1, 1) * l.residual.y();
        variance -= s(0, 1) * s(0, 1) / s(1, 1);
    }
    if (!seen.range) return log;
    const double sigma = grown(source.range_factor * seen.range_sigma, source.stretch, *seen.range);
    const Gaussian1 prior{expected, std::max(variance - sigma * sigma, 1e-12)};
    return log + measure_range(prior, l.residual.x(), sigma, source.late).log_evidence;
}

/// The mixture of what a measurement gives and of what was believed before.
Gaussian1 blend(const Gaussian1& before, const Gaussian1& after, double weight) {
    const double mean = weight * after.mean + (1 - weight) * before.mean;
    const double apart = after.mean - before.mean;
    return {mean, weight * after.variance + (1 - weight) * before.variance + weight * (1 - weight) * apart * apart};
}

}  // namespace

DetectorSource learned(DetectorSource source, const SenseNoise& noise) {
    source.range_factor *= noise.detector.factor;
    source.range_common = std::max(source.range_common, noise.detector.common);
    source.range_own = std::max(source.range_own, noise.detector.own);
    source.range_wander = std::max(source.range_wander, noise.detector.wander);
    source.stretch = noise.detector.stretch;
    source.bearing_factor *= noise.bearing;
    source.bearing_common = std::max(source.bearing_common, noise.bearing_common);
    source.range_sway = noise.detector.sway;
    source.bearing_shape = noise.bearing_shape;
    source.bearing_sway = noise.bearing_sway;
    source.wander_way *= noise.detector.way;
    return source;
}

PredictedSighting predict_sighting(const Pose2& pose, const Eigen::Vector2d& detector, const Eigen::Vector2d& mark) {
    const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
    const Eigen::Vector2d arm(c * detector.x() - s * detector.y(), s * detector.x() + c * detector.y());
    const Eigen::Vector2d way = mark - Eigen::Vector2d(pose.x, pose.y) - arm;
    const double range = std::max(way.norm(), 0.01);
    PredictedSighting predicted;
    predicted.range = range;
    predicted.bearing = wrap_angle(std::atan2(way.y(), way.x()) - pose.yaw);
    predicted.range_by_pose = {-way.x() / range, -way.y() / range, (way.x() * arm.y() - way.y() * arm.x()) / range};
    predicted.bearing_by_pose = {way.y() / (range * range), -way.x() / (range * range), -1 - way.dot(arm) / (range * range)};
    return predicted;
}

void add_slow_states(Belief& belief, const SightingObservation& seen, int landmark, const DetectorSource& source) {
    const double forget = 1 / source.bias_memory;
    for (int axis = 0; axis < 2; ++axis) {
        const double sigma = source.position_sigma[axis];
        if (sigma > 0) ensure_slow(belief, {SlowKind::receiver_place, of_detector, axis, sigma * sigma});
    }
    const auto add = [&](SlowKind kind, int component, double sigma, double per_second, double per_metre) {
        if (sigma > 0) ensure_slow(belief, {kind, of_detector, component, sigma * sigma, per_second, per_metre});
    };
    if (seen.range) {
        add(SlowKind::range_bias, all_landmarks, source.range_common, forget, 0);
        add(SlowKind::range_bias, landmark, source.range_own, forget, 0);
        add(SlowKind::range_wander, landmark, source.range_wander, 0, 1 / source.wander_way);
        add(SlowKind::range_wander, all_landmarks, source.range_sway, 0, 1 / source.wander_way);
        add_slow_states(belief, of_detector, source.stretch, forget);
    }
    if (seen.bearing) {
        add(SlowKind::bearing_bias, 0, source.bearing_common, forget, 0);
        add(SlowKind::bearing_wander, all_landmarks, source.bearing_sway, 0, 1 / source.wander_way);
        for (int component = 0; component < bearing_shapes; ++component) add(SlowKind::bearing_shape, component, source.bearing_shape, 0, 0);
    }
}

Linearised<2> linearise_sighting(const Belief& belief, const SightingObservation& seen, int landmark, const Mark& mark, const DetectorSource& source) {
    std::array<std::optional<int>, 2> places;
    Eigen::Vector2d detector = source.position;
    for (int axis = 0; axis < 2; ++axis) {
        auto& place = places[static_cast<std::size_t>(axis)];
        if (source.position_sigma[axis] > 0) place = find_slow(belief, SlowKind::receiver_place, of_detector, axis);
        if (place) detector[axis] += belief.mean[*place];
    }
    const PredictedSighting exact = predict_sighting(belief.pose(), detector, mark.place);
    Linearised<2> l;
    const StretchedRange stated = stretched(belief, of_detector, source.stretch, exact.range, exact.bearing);
    const BearingShape shape(belief, source, exact.bearing);
    for (int i = 0; i < 3; ++i) {
        const double range = stated.by_range * exact.range_by_pose[i] + stated.by_bearing * exact.bearing_by_pose[i];
        l.depends(i, {seen.range ? range : 0, seen.bearing ? shape.by_bearing * exact.bearing_by_pose[i] : 0});
    }
    const double place = mark.sigma;
    l.noise(0, 0) = l.noise(1, 1) = unseen;
    const auto depends = [&](SlowKind kind, int component, double sigma, int row) {
        if (!(sigma > 0)) return;
        if (const auto slow = find_slow(belief, kind, of_detector, component)) {
            l.depends_on_slow(belief, *slow, Column::Unit(row));
        } else {
            l.noise(row, row) += sigma * sigma;
        }
    };
    if (seen.range) {
        const double sigma = grown(source.range_factor * seen.range_sigma, source.stretch, *seen.range);
        l.residual[0] = *seen.range - stated.value;
        l.noise(0, 0) = sigma * sigma + place * place + stated.noise;
        for (std::size_t i = 0; i < stated.states.size(); ++i) l.depends(stated.states[i], {stated.by_state[i], 0});
        depends(SlowKind::range_bias, all_landmarks, source.range_common, 0);
        depends(SlowKind::range_bias, landmark, source.range_own, 0);
        depends(SlowKind::range_wander, landmark, source.range_wander, 0);
        depends(SlowKind::range_wander, all_landmarks, source.range_sway, 0);
    }
    if (seen.bearing) {
        const double sigma = source.bearing_factor * seen.bearing_sigma;
        l.residual[1] = *seen.bearing - exact.bearing - shape.value;
        for (std::size_t i = 0; i < shape.states.size(); ++i) l.depends(shape.states[i], {0, shape.by_state[i]});
        l.noise(1, 1) = sigma * sigma + std::pow(place / exact.range, 2);
        depends(SlowKind::bearing_bias, 0, source.bearing_common, 1);
        depends(SlowKind::bearing_wander, all_landmarks, source.bearing_sway, 1);
        l.residual[1] = wrap_angle(l.residual[1]);
    }
    const Eigen::Rotation2Dd turn(belief.mean[state_yaw]);
    for (int axis = 0; axis < 2; ++axis) {
        // Along its axis the detector moves as the robot would.
        const Eigen::Vector2d along = turn * Eigen::Vector2d(Eigen::Vector2d::Unit(axis));
        const double bearing = exact.bearing_by_pose.head<2>().dot(along);
        const double range = stated.by_range * exact.range_by_pose.head<2>().dot(along) + stated.by_bearing * bearing;
        const Column by_place(seen.range ? range : 0, seen.bearing ? shape.by_bearing * bearing : 0);
        if (const auto& where = places[static_cast<std::size_t>(axis)]) {
            l.depends(*where, by_place);
        } else {
            l.noise += std::pow(source.position_sigma[axis], 2) * by_place * by_place.transpose();
        }
    }
    return l;
}

double prior_of(const SightingObservation& seen, int landmark, const std::vector<Mark>& marks, const DetectorSource& source) {
    const bool plain = marks[static_cast<std::size_t>(landmark)].plain;
    const auto others = static_cast<double>(std::count_if(marks.begin(), marks.end(), [](const Mark& m) { return m.plain; }));
    if (seen.landmark < 0) return plain ? 1 / others : 0;
    if (seen.landmark == landmark) return others > 1 ? 1 - source.misread : 1;
    return plain && others > 1 ? source.misread / (others - 1) : 0;
}

/// What a sighting may be.
struct LandmarkAssociation {
    int likeliest = -1;       // index of the landmark; -1: none can be
    double log_evidence = 0;  // of all that it may be
    double weight = 0;        // probability of the likeliest
};

/// Is a landmark so far from what was seen that it cannot be it, whatever the errors? Asked of each before anything dear is computed.
static bool out_of_the_question(const Belief& belief, const SightingObservation& seen, const Mark& mark, const DetectorSource& source) {
    constexpr double many = 8;                                     // standard deviations of the pose
    constexpr double range_apart = 0.5, part = 0.4, turned = 0.5;  // m, of the range, rad: what is left to the sensor's own errors
    const PredictedSighting there = predict_sighting(belief.pose(), source.position, mark.place);
    const double place = many * belief.place_sigma();
    if (seen.range) {
        const double nearest = source.stretch.depth > 0 ? 0 : there.range;  // depths are anything up to the distance
        if (nearest - *seen.range > place + range_apart + part * nearest || *seen.range - there.range > place + range_apart + part * *seen.range) return true;
    }
    const double front = many * std::sqrt(belief.covariance(state_yaw, state_yaw)) + place / there.range + turned;
    return seen.bearing && std::abs(wrap_angle(*seen.bearing - there.bearing)) > front;
}

static LandmarkAssociation associate(const Belief& belief, const SightingObservation& seen, const std::vector<Mark>& marks, const DetectorSource& source,
                                     double outliers) {
    const double nothing = std::log(outliers) + log_anywhere(seen);
    double most = nothing, best = -1e300, sum = 1;  // of the densities, over the largest
    LandmarkAssociation association;
    for (std::size_t i = 0; i < marks.size(); ++i) {
        const auto landmark = static_cast<int>(i);
        const double prior = prior_of(seen, landmark, marks, source);
        if (prior <= 0 || out_of_the_question(belief, seen, marks[i], source)) continue;
        const double log =
            std::log((1 - outliers) * prior) + log_likelihood(belief, seen, linearise_sighting(belief, seen, landmark, marks[i], source), source);
        sum = log > most ? sum * std::exp(most - log) + 1 : sum + std::exp(log - most);
        most = std::max(most, log);
        if (log <= best) continue;
        best = log;
        association.likeliest = landmark;
    }
    association.log_evidence = most + std::log(sum);
    association.weight = std::exp(best - association.log_evidence);
    return association;
}

std::optional<int> likeliest_mark(const Belief& belief, const SightingObservation& seen, const std::vector<Mark>& marks, const DetectorSource& source,
                                  double outliers) {
    const LandmarkAssociation association = associate(belief, seen, marks, source, outliers);
    if (association.likeliest < 0 || association.weight < 0.5) return std::nullopt;
    return association.likeliest;
}

static void take_bearing(Belief& belief, const Linearised<2>& l, double belongs, Innovation& innovation) {
    Linearised<1> bearing;
    bearing.residual[0] = l.residual[1];
    bearing.noise(0, 0) = l.noise(1, 1);
    for (std::size_t k = 0; k < l.states.size(); ++k) bearing.depends(l.states[k], Eigen::Matrix<double, 1, 1>(l.by_state(1, static_cast<Eigen::Index>(k))));
    OutlierModel outliers;
    outliers.gate = gate;
    outliers.belongs = belongs;
    const Innovation taken = update(belief, bearing, outliers);
    innovation.right = std::min(innovation.right, taken.right);
    innovation.nis += taken.nis;
    innovation.dimensions += 1;
}

static void take_range(Belief& belief, const SightingObservation& seen, const Linearised<2>& l, double belongs, const DetectorSource& source,
                       Innovation& innovation) {
    const double sigma = std::sqrt(l.noise(0, 0));
    const double predicted = *seen.range - l.residual[0];
    const Eigen::Matrix<double, 1, most_columns> by_state = l.by_state.row(0);
    const LatePosterior taken = update_scalar(belief, predicted, l.states, by_state, [&](const Gaussian1& prior) {
        LatePosterior posterior = measure_range(prior, *seen.range, sigma, source.late);
        posterior.value = blend(prior, posterior.value, belongs);
        return posterior;
    });
    innovation.right = std::min(innovation.right, belongs * taken.on_time);
    innovation.nis += taken.nis;
    innovation.dimensions += 1;
}

std::optional<Innovation> update_sighting(Belief& belief, const SightingObservation& seen, const std::vector<Mark>& marks, const DetectorSource& source,
                                          double outliers) {
    constexpr double hardly = 0.02;  // such a weight moves nothing
    if (rows_of(seen) == 0) return std::nullopt;
    const LandmarkAssociation association = associate(belief, seen, marks, source, outliers);
    Innovation innovation{association.log_evidence, 0, 0, 0};
    if (association.likeliest < 0 || association.weight < hardly) return innovation;
    const int landmark = association.likeliest;
    const Mark& mark = marks[static_cast<std::size_t>(landmark)];
    add_slow_states(belief, seen, landmark, source);
    innovation.right = 1;
    if (seen.bearing) take_bearing(belief, linearise_sighting(belief, seen, landmark, mark, source), association.weight, innovation);
    if (seen.range) take_range(belief, seen, linearise_sighting(belief, seen, landmark, mark, source), association.weight, source, innovation);
    return innovation;
}

}  // namespace roomfix
