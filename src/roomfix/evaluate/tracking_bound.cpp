#include "roomfix/evaluate/tracking_bound.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/estimate/landmark_model.hpp"
#include "roomfix/evaluate/robot_point.hpp"

namespace roomfix {
namespace {

constexpr double start_sigma = 10;  // m: before anything was measured
constexpr double truth_gap = 2;     // s: where the truth is silent for longer, nothing is known of the motion

/// The true way of a robot; its rates are those between the moments around.
Trajectory true_trajectory(const std::vector<StampedPose>& poses) {
    Trajectory way;
    for (const StampedPose& p : poses) {
        if (!way.times.empty() && p.time <= way.times.back()) continue;
        Knot knot = Knot::Zero();
        knot.head<3>() << p.pose.x, p.pose.y, p.pose.yaw;
        if (!way.knots.empty()) knot[2] = way.knots.back()[2] + wrap_angle(p.pose.yaw - way.knots.back()[2]);
        way.times.push_back(p.time);
        way.knots.push_back(knot);
    }
    for (std::size_t i = 0; i < way.knots.size(); ++i) {
        const std::size_t before = i > 0 ? i - 1 : i, after = std::min(i + 1, way.knots.size() - 1);
        if (after == before) continue;
        way.knots[i].tail<3>() = (way.knots[after].head<3>() - way.knots[before].head<3>()) / to_seconds(way.times[after] - way.times[before]);
    }
    return way;
}

/// Takes one observation into a bound.
struct Learner {
    TrackingBound& bound;
    const TrackingModels& models;
    int source;
    const RangeSource& receiver;

    void operator()(const PoseObservation& o) const {
        const PoseSource& errors = models.fixed.at(source);
        add_slow_states(bound.belief(), o, errors);
        if (o.yaw_known) {
            bound.learn(linearise_pose(bound.belief(), o, errors));
        } else {
            bound.learn(linearise_place(bound.belief(), o, errors));
        }
    }
    void operator()(const TagSighting& s) const {
        const PoseSource& errors = models.fixed.at(source);
        add_slow_states(bound.belief(), errors, s.time_error);
        if (const auto l = linearise_tag(bound.belief(), s.corners, models.views.at(source), models.site.robots[static_cast<std::size_t>(s.robot)], errors,
                                         s.time_error)) {
            bound.learn(*l);
        }
    }
    void operator()(const SeenLandmark& s) const {
        const OnboardSource& camera = models.onboard.at(source);
        const KnownLandmark landmark = models.landmark(s.landmark);
        add_slow_states(bound.belief(), landmark, camera, s.seen.time_error);
        if (s.seen.points.size() == 3) {
            if (const auto l = linearise_points<3>(bound.belief(), s.seen, landmark, camera)) bound.learn(*l);
        } else {
            if (const auto l = linearise_points<4>(bound.belief(), s.seen, landmark, camera)) bound.learn(*l);
        }
    }
    void operator()(const SeenCorner& s) const {
        const OnboardSource& camera = models.onboard.at(source);
        add_slow_states(bound.belief(), s.corner, camera, s.seen.time_error);
        const SiteCorner& corner = models.site.corners[static_cast<std::size_t>(s.corner)];
        if (const auto l = linearise_corner(bound.belief(), s.seen, corner, s.corner, camera)) bound.learn(*l);
    }
    void operator()(const SeenMark& s) const {
        const DetectorSource& detector = models.detectors[static_cast<std::size_t>(s.seen.robot)];
        add_slow_states(bound.belief(), s.seen, s.landmark, detector);
        bound.learn(linearise_sighting(bound.belief(), s.seen, s.landmark, models.marks[static_cast<std::size_t>(s.landmark)], detector));
    }
    void operator()(const RangeObservation& o) const {
        add_slow_states(bound.belief(), o.beacon, receiver);
        const Eigen::Vector3d& beacon = models.site.beacons[static_cast<std::size_t>(o.beacon)].position;
        learn_range(predict_measured_range(bound.belief(), bound.belief().pose(), o.beacon, beacon, receiver), o.sigma);
    }
    void operator()(const RangeDifferenceObservation& o) const {
        const Eigen::Vector3d& first = models.site.beacons[static_cast<std::size_t>(o.beacons[0])].position;
        const Eigen::Vector3d& second = models.site.beacons[static_cast<std::size_t>(o.beacons[1])].position;
        // The late part of a difference has two sides; a range's is close to it.
        learn_range(predict_difference(bound.belief(), bound.belief().pose(), first, second, receiver), o.sigma);
    }
    void learn_range(const PredictedValue& predicted, double sigma) const {
        Linearised<1> l;
        l.noise(0, 0) = 1 / bound.range_information(sigma, receiver.late);
        for (std::size_t k = 0; k < predicted.states.size(); ++k) {
            l.depends(predicted.states[k], Eigen::Matrix<double, 1, 1>(predicted.by_state[static_cast<Eigen::Index>(k)]));
        }
        bound.learn(l);
    }
};

/// The bounds of one robot's fixes, which are in the order of their times.
void bounds_of_robot(int robot, const Tracker& tracker, const std::vector<std::optional<Trajectory>>& true_ways, const std::vector<const Fix*>& fixes,
                     const std::function<void(const Fix*, const Eigen::Matrix3d&)>& give) {
    const TrackingModels& models = tracker.models();
    const Trajectory& way = *true_ways[static_cast<std::size_t>(robot)];
    const OdometryTrack& driven = tracker.history()->driven[static_cast<std::size_t>(robot)];
    const auto measured = measured_of(robot, *tracker.history(), tracker.groups(), models, true_ways);
    TrackingBound bound(models, robot, [&](Nanoseconds time) {
        StateVector state = StateVector::Zero();
        state.head<6>() = way.at(std::clamp(time, way.start(), way.end()));
        return state;
    });
    Eigen::Matrix3d nothing_known = start_sigma * start_sigma * Eigen::Matrix3d::Identity();
    nothing_known(2, 2) = unknown_yaw_variance;
    auto next = measured.begin();
    for (const Fix* fix : fixes) {
        for (; next != measured.end() && next->time <= fix->time; ++next) {
            if (!bound.started()) bound.start(next->time, nothing_known);
            bound.predict_to(next->time, driven);
            bound.learn(*next);
        }
        if (!bound.started()) continue;
        bound.predict_to(fix->time, driven);
        give(fix, bound.belief().pose_covariance());
    }
}

}  // namespace

void TrackingBound::start(Nanoseconds time, const Eigen::Matrix3d& covariance) {
    const StateVector at = truth_(time);
    belief_ = belief_at({at[state_x], at[state_y], at[state_yaw]}, covariance, models_.settings.start_speed, models_.settings.start_turning,
                        models_.odometry[robot_]);
    time_ = time;
    started_ = true;
    stand_at_truth(time);
}

void TrackingBound::stand_at_truth(Nanoseconds time) {
    belief_.mean.head<core_states>() = truth_(time).head<core_states>();
    belief_.mean.tail<most_slow_states>().setZero();
}

void TrackingBound::predict_to(Nanoseconds time, const OdometryTrack& driven) {
    while (time_ < time) {
        stand_at_truth(time_);
        const OdometryTrack::Piece piece = driven.piece(time_, time);
        if (piece.driven) {
            predict(belief_, piece.step, models_.settings.odometry);
        } else {
            predict(belief_, to_seconds(piece.end - time_), models_.motion[robot_]);
        }
        time_ = piece.end;
    }
    stand_at_truth(time);
}

void TrackingBound::learn(const Measured& measured) {
    std::visit(Learner{*this, models_, measured.source, models_.receiver(static_cast<int>(robot_))}, measured.what);
}

double TrackingBound::range_information(double sigma, const LateModel& late) {
    const auto [known, is_new] = information_.try_emplace(sigma, 0.0);
    if (!is_new) return known->second;
    const double step = sigma / 20;
    for (double e = -8 * sigma; e < 10 * late.mean; e += step) {
        // The density itself: in range_likelihood the late part is counted once.
        const RangeLikelihood l = range_likelihood(e, sigma, late);
        known->second += l.slope * l.slope * std::exp(l.log_density) * step;
    }
    return known->second;
}

std::vector<std::optional<Eigen::Matrix3d>> tracking_bounds(const Tracker& tracker, const std::vector<Fix>& fixes, const Truth& truth_of_point,
                                                            const std::function<void(double)>& progress, const Eigen::Vector2d& point) {
    const Truth truth = true_middles(truth_of_point, fixes, point);
    std::vector<std::optional<Eigen::Matrix3d>> bounds(fixes.size());
    const std::vector<SiteRobot>& robots = tracker.models().site.robots;
    std::vector<std::optional<Trajectory>> true_ways(robots.size());
    for (std::size_t r = 0; r < robots.size(); ++r) {
        const auto poses = truth.find(robots[r].id);
        if (poses != truth.end() && poses->second.size() > 1) true_ways[r] = true_trajectory(poses->second);
        if (true_ways[r] && true_ways[r]->times.size() < 2) true_ways[r].reset();
    }
    for (std::size_t r = 0; r < robots.size(); ++r) {
        if (progress) progress(static_cast<double>(r) / static_cast<double>(robots.size()));
        if (!true_ways[r]) continue;
        std::vector<const Fix*> own;
        for (const Fix& fix : fixes) {
            if (fix.robot == robots[r].id && pose_at(truth.at(fix.robot), fix.time, truth_gap)) own.push_back(&fix);
        }
        std::stable_sort(own.begin(), own.end(), [](const Fix* a, const Fix* b) { return a->time < b->time; });
        bounds_of_robot(static_cast<int>(r), tracker, true_ways, own,
                        [&](const Fix* fix, const Eigen::Matrix3d& bound) { bounds[static_cast<std::size_t>(fix - fixes.data())] = bound; });
    }
    if (progress) progress(1);
    return bounds;
}

}  // namespace roomfix
