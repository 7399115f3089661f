#include "roomfix/estimate/track.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "roomfix/estimate/iterated_update.hpp"
#include "roomfix/estimate/own_senses.hpp"
#include "roomfix/estimate/time_error_model.hpp"
#include "roomfix/estimate/track_start.hpp"

namespace roomfix {
namespace {

constexpr double moving_speed = 0.15;     // m/s: faster, the direction of motion tells which end is the front
constexpr double memory_of_health = 2;    // s: so long a source may be wrong
constexpr double longest_judged = 1;      // s that one observation speaks for, at most
constexpr double confirmed_within = 2.0;  // s: so old may another source's word be to judge by
constexpr double sure_enough = 0.2;       // m: a place known less judges nobody
constexpr double front_doubt = 0.02;      // weight of other fronts where the robot seems to drive backwards or sideways

OutlierModel outlier_model(int dimensions, const TrackerSettings& settings) {
    const double spread = dimensions == 2 ? settings.area : settings.area * 2 * std::numbers::pi;
    return {settings.outliers, settings.gate + 2 * dimensions, -std::log(spread)};
}

/// Of pixels or angles: an outlier may have any value within a range of that many units each.
OutlierModel outlier_model_over(int dimensions, double range, const TrackerSettings& settings) {
    return {settings.outliers, settings.gate + 2 * dimensions, -dimensions * std::log(range)};
}

/// Has anything but `source` confirmed the robot lately?
bool confirmed_otherwise(const Track& track, int source) {
    if (track.belief.best().place_sigma() > sure_enough) return false;
    return std::any_of(track.sources.begin(), track.sources.end(),
                       [&](const SourceHealth& s) { return s.source != source && to_seconds(track.time - s.seen) < confirmed_within; });
}

void judge(SourceHealth& health, Nanoseconds time, const Innovation& innovation, double distance, bool judgeable, const TrackerSettings& settings) {
    health.nis = innovation.nis;
    health.dimensions = innovation.dimensions;
    const double since = health.judged_at == never ? 0.1 : to_seconds(time - health.judged_at);
    health.judged_at = time;
    if (!judgeable) return;
    const double share = 1 - std::exp(-std::min(since, longest_judged) / memory_of_health);
    health.right += share * (innovation.right - health.right);
    health.distance += share * (distance - health.distance);
    ++health.judged;
    if (!health.quarantined && health.judged >= settings.quarantine_after && health.right < settings.quarantine_below) health.quarantined = true;
    if (health.quarantined && health.right > settings.readmit_above) health.quarantined = false;
}

/// Log evidence of all hypotheses together, by their weights before.
double mixed(const RobotBelief& belief, const std::vector<double>& evidence) {
    double sum = 0;
    double most = evidence[0];
    for (const double e : evidence) most = std::max(most, e);
    for (std::size_t i = 0; i < evidence.size(); ++i) sum += std::exp(belief.hypotheses[i].log_weight + evidence[i] - most);
    return most + std::log(std::max(sum, 1e-300));
}

/// Updates every hypothesis by `update_one(belief)` -> optional<Innovation>, weighs them, and judges the source.
template <class UpdateOne>
double take_with(Track& track, int source, const std::vector<PlaceProposal>& proposals, const TrackingModels& models, const UpdateOne& update_one,
                 double* right = nullptr) {
    const TrackerSettings& settings = models.settings;
    const bool judgeable = confirmed_otherwise(track, source);
    SourceHealth& health = health_of(track, source);
    thread_local std::vector<double> evidence;
    evidence.clear();
    Innovation best;
    double distance = 0;
    // Where nobody knows better, even a source in quarantine is better than none.
    const bool quarantined = health.quarantined && track.belief.best().place_sigma() < models.site.lost;
    for (std::size_t i = 0; i < track.belief.hypotheses.size(); ++i) {
        Belief& belief = track.belief.hypotheses[i].belief;
        std::optional<Innovation> innovation;
        if (quarantined) {
            Belief tried = belief;
            innovation = update_one(tried);
        } else {
            innovation = update_one(belief);
        }
        if (!innovation) innovation = Innovation{-30, 0, 0, 0};
        evidence.push_back(innovation->log_evidence);
        if (i == 0) {
            best = *innovation;
            distance = proposals.empty() ? 0 : std::hypot(proposals[0].pose.x - belief.mean[0], proposals[0].pose.y - belief.mean[1]);
        }
    }
    if (right != nullptr) *right = best.right;
    judge(health, track.time, best, distance, judgeable, settings);
    if (quarantined) return 0;
    const double together = mixed(track.belief, evidence);
    track.budget -= weigh(track.belief, evidence, std::max(track.budget, 0.0));
    if (best.right > 0.5) {
        track.seen = track.time;
        track.absence = 0;
        health.seen = track.time;
        ++track.sightings;
    } else if (best.right < 0.05 && !proposals.empty()) {
        add_places(track, proposals, settings.kidnapping, models);
    }
    settle(track.belief);
    return together;
}

/// The landmark that an observation most likely shows, seen from a belief.
std::optional<Innovation> take_landmarks(Belief& belief, const LandmarkSighting& seen, int source, const TrackingModels& models) {
    const OnboardSource& camera = models.onboard.at(source);
    std::optional<Innovation> total;
    for (const LandmarkObservation& observation : seen.landmarks) {
        const Belief before = belief;
        std::optional<Belief> best_belief;
        Innovation best;
        best.log_evidence = -std::numeric_limits<double>::infinity();
        for (const int shape : observation.shapes) {
            for (const int landmark : models.shapes[static_cast<std::size_t>(shape)].landmarks) {
                const OutlierModel outliers = outlier_model_over(2 * static_cast<int>(observation.points.size()), 100, models.settings);
                Belief tried = before;
                const auto innovation = update_landmark(tried, observation, models.landmark(landmark), camera, outliers);
                if (!innovation || innovation->log_evidence <= best.log_evidence) continue;
                best = *innovation;
                best_belief = tried;
            }
        }
        if (!best_belief) best = {-30, 0, 0, 0};
        if (best_belief) belief = *best_belief;
        if (!total) total = Innovation{0, 0, 0, 0};
        total->log_evidence += best.log_evidence;
        total->right = std::max(total->right, best.right);
        total->nis += best.right > 0.05 ? best.nis : 0;
        total->dimensions += best.right > 0.05 ? best.dimensions : 0;
    }
    return total;
}

/// The corner that an observation most likely shows, seen from a belief; the picture's readings exclude each other.
std::optional<Innovation> take_corners(Belief& belief, const CornerSighting& seen, int source, const TrackingModels& models) {
    const OnboardSource& camera = models.onboard.at(source);
    const Belief before = belief;
    std::optional<Innovation> best;
    for (const CornerObservation& observation : seen.corners) {
        for (std::size_t k = 0; k < models.site.corners.size(); ++k) {
            const SiteCorner& corner = models.site.corners[k];
            if (std::abs(corner.wall_angle - observation.wall_angle) > 0.01) continue;
            const double distance = corner.position.z() - camera.camera.robot_from_camera.pose.translation().z();
            if (!(distance > corner.moulding.value_or(0))) continue;
            for (const CornerReading& reading : readings_of(observation, corner.moulding, distance)) {
                Belief tried = before;
                const OutlierModel outliers{models.settings.outliers, models.settings.gate + 10, -std::log(8 * std::numbers::pi * std::numbers::pi * 25)};
                auto innovation = update_corner(tried, reading.seen, corner, static_cast<int>(k), camera, outliers);
                if (!innovation) continue;
                innovation->log_evidence += std::log(std::max(observation.weight * reading.weight, 1e-6));
                if (best && innovation->log_evidence <= best->log_evidence) continue;
                best = innovation;
                belief = tried;
            }
        }
    }
    return best;
}

/// A picture of nothing but a place to start from.
void take_places(Track& track, const PlaceSighting& seen, const TrackingModels& models) {
    if (track.belief.hypotheses.size() > 1 || seen.proposals.empty()) return;
    Belief proposed = start_belief(seen.proposals[0], track.robot, models);
    if (pose_distance(proposed, track.belief.best()) > 16) add_places(track, seen.proposals, models.settings.kidnapping, models);
}

}  // namespace

SourceHealth& health_of(Track& track, int source) {
    for (SourceHealth& health : track.sources) {
        if (health.source == source) return health;
    }
    if (track.sources.size() < track.sources.capacity()) {
        track.sources.push_back({source});
        return track.sources[track.sources.size() - 1];
    }
    SourceHealth* oldest = &track.sources[0];
    for (SourceHealth& health : track.sources) {
        if (health.seen < oldest->seen) oldest = &health;
    }
    *oldest = SourceHealth{source};
    return *oldest;
}

void note_absence(Track& track, const AbsenceObservation& observation, const TrackerSettings& settings) {
    constexpr double longest = 0.25;  // s that one observation speaks for
    constexpr double gate = 9;        // squared Mahalanobis distance from where the cameras looked
    const Belief& belief = track.belief.best();
    const Eigen::Vector2d off(observation.place.x - belief.mean[0], observation.place.y - belief.mean[1]);
    if (off.dot(belief.covariance.topLeftCorner<2, 2>().inverse() * off) > gate) return;
    const double since = std::min(to_seconds(track.time - std::max(track.absent_at, track.seen)), longest);
    track.absence += observation.nats * since / settings.hidden_for;
    track.absent_at = track.time;
}

double probability_elsewhere(const Track& track, const TrackerSettings& settings) {
    return settings.surprise / (settings.surprise + (1 - settings.surprise) * std::exp(track.absence));
}

bool is_missing(const Track& track, const TrackerSettings& settings) { return probability_elsewhere(track, settings) > 0.5; }

void predict(Track& track, Nanoseconds time, const TrackingModels& models) {
    if (time <= track.time) return;
    const auto robot = static_cast<std::size_t>(track.robot);
    const MotionModel motion = learned(models.motion[robot], track.noise);
    const OdometryNoise wheels = learned(models.wheels[robot], track.noise);
    track.budget = std::min(most_budget, track.budget + models.settings.conviction * to_seconds(time - track.time));
    const bool several = track.belief.hypotheses.size() > 1;
    const Nanoseconds delay = from_seconds(wheels.delay);
    while (track.time < time) {
        OdometryTrack::Piece piece;
        piece.end = time;
        if (track.named) {
            piece = models.driven[robot].piece(track.time - delay, time - delay);
            piece.end += delay;
        }
        const double seconds = to_seconds(piece.end - track.time);
        for (Hypothesis& h : track.belief.hypotheses) {
            if (piece.driven) {
                predict(h.belief, piece.step, wheels);
                continue;
            }
            predict(h.belief, seconds, motion);
            if (!several || motion.drive == Drive::holonomic || !h.belief.yaw_known()) continue;
            // Which end is the front: robots seldom drive backwards.
            const double forward = h.belief.forward_speed();
            const double speed = h.belief.mean.segment<2>(state_vx).norm();
            if (speed > moving_speed) h.log_weight -= models.settings.backwards * seconds * (speed - forward);
        }
        track.time = piece.end;
    }
    if (several) settle(track.belief);
}

/// A body that looks the same from several sides, and drives another way than it faces: perhaps it faces that way.
void doubt_the_front(Track& track, const PoseObservation& observation, const PoseSource& errors, const TrackingModels& models) {
    if (observation.like_turns < 2 || track.belief.hypotheses.size() > 1 || models.motion[static_cast<std::size_t>(track.robot)].drive == Drive::holonomic)
        return;
    const Belief& belief = track.belief.best();
    const Eigen::Vector2d velocity = belief.mean.segment<2>(state_vx);
    const double forward = belief.forward_speed();
    const double turn = 2 * std::numbers::pi / observation.like_turns;
    if (velocity.norm() < moving_speed || forward > velocity.norm() * std::cos(0.75 * turn)) return;
    add_places(track, places_of(observation, errors), front_doubt, models);
}

/// A body that looks the same from several sides, of a robot that is hardly known to face one of them: each is a hypothesis of its own.
void face_each_way(Track& track, const PoseObservation& observation) {
    if (observation.like_turns < 2 || !observation.yaw_known) return;
    constexpr double far = 2;  // standard deviations: half a turn farther is out of the question
    const double turn = 2 * std::numbers::pi / observation.like_turns;
    auto& hypotheses = track.belief.hypotheses;
    const std::size_t before = hypotheses.size();
    for (std::size_t i = 0; i < before; ++i) {
        const Belief& belief = hypotheses[i].belief;
        const double variance = belief.covariance(state_yaw, state_yaw) + observation.covariance(2, 2);
        if (far * std::sqrt(variance) < 0.5 * turn) continue;
        const std::size_t last = hypotheses.size();
        const double nearest = std::remainder(observation.pose.yaw - belief.mean[state_yaw], turn);
        double sum = 1;
        for (int k = 1; k < observation.like_turns && hypotheses.size() < most_hypotheses; ++k) {
            Hypothesis other = hypotheses[i];
            const double off = std::remainder(nearest + k * turn, 2 * std::numbers::pi);
            const double behind = 0.5 * (off * off - nearest * nearest) / variance;
            other.belief.mean[state_yaw] = wrap_angle(other.belief.mean[state_yaw] + off - nearest);
            other.log_weight -= behind;
            hypotheses.push_back(other);
            sum += std::exp(-behind);
        }
        hypotheses[i].log_weight -= std::log(sum);
        for (std::size_t k = last; k < hypotheses.size(); ++k) hypotheses[k].log_weight -= std::log(sum);
    }
}

double take_pose(Track& track, const PoseObservation& observation, int source, const TrackingModels& models, bool certain) {
    const PoseSource& errors = models.fixed.at(source);
    doubt_the_front(track, observation, errors, models);
    face_each_way(track, observation);
    OutlierModel outliers = outlier_model(observation.yaw_known ? 3 : 2, models.settings);
    if (certain) outliers.gate = std::numeric_limits<double>::infinity();
    thread_local std::vector<PlaceProposal> places;
    list_places(observation, errors, places);
    return take_with(track, source, places, models, [&](Belief& belief) -> std::optional<Innovation> {
        add_slow_states(belief, observation, errors);
        if (!observation.yaw_known) return update(belief, linearise_place(belief, observation, errors), outliers);
        return update(belief, linearise_pose(belief, observation, errors), outliers);
    });
}

/// s, of the time of the frame in which a robot's own camera saw these.
template <class Observation>
double frame_sigma(const std::vector<Observation>& seen, const Event& event, const TrackingModels& models) {
    return time_sigma(models.onboard.at(event.source).time_offset_sigma, seen.empty() ? TimeError{} : seen.front().time_error);
}

/// Is a sighting that names places to be the track's start? At first, after so long unseen that what is believed says nothing, and where it is not seen
/// although it should be.
bool begins(const Track& track, const TrackingModels& models) {
    return !track.alive() || track.belief.best().place_sigma() > models.settings.anywhere || is_missing(track, models.settings);
}

double take(Track& track, const Event& event, const TrackingModels& models) {
    const auto fuse = [&](const std::vector<PlaceProposal>& proposals, double sigma_of_frame, const auto& update_one) {
        if (track.alive() && (proposals.empty() || !begins(track, models))) return take_with(track, event.source, proposals, models, update_one);
        if (!proposals.empty()) {
            std::vector<PlaceProposal> places = proposals;
            for (PlaceProposal& place : places) place.time_sigma = sigma_of_frame;
            start(track, places, event.time, models);
            health_of(track, event.source).seen = event.time;
        }
        return 0.0;
    };
    const auto own_sense = [&](const auto& update_one) {
        double right = 0;
        const double evidence = take_with(track, event.source, {}, models, update_one, &right);
        track.evidence += evidence;
        ++track.weighed;
        note_agreement(track, right, models);
        return evidence;
    };
    struct Visitor {
        Track& track;
        const Event& event;
        const TrackingModels& models;
        const decltype(fuse)& fuse_with;
        const decltype(own_sense)& by_own_sense;

        double operator()(const PoseObservation& o) const {
            if (!begins(track, models)) return take_pose(track, o, event.source, models);
            start(track, places_of(o, models.fixed.at(event.source)), event.time, models);
            health_of(track, event.source).seen = event.time;
            return 0;
        }
        double operator()(const GroupSighting&) const { return 0; }
        double operator()(const TagSighting& s) const {
            const PoseSource& camera = models.fixed.at(event.source);
            const View& view = models.views.at(event.source);
            const SiteRobot& robot = models.site.robots[static_cast<std::size_t>(s.robot)];
            return fuse_with(s.proposals, time_sigma(camera.time_offset_sigma, s.time_error), [&](Belief& b) {
                add_slow_states(b, camera, s.time_error);
                return iterated_update<8>(b, outlier_model_over(8, 100, models.settings),
                                          [&](const Belief& at) { return linearise_tag(at, s.corners, view, robot, camera, s.time_error); });
            });
        }
        double operator()(const LandmarkSighting& s) const {
            return fuse_with(s.proposals, frame_sigma(s.landmarks, event, models), [&](Belief& b) { return take_landmarks(b, s, event.source, models); });
        }
        double operator()(const CornerSighting& s) const {
            return fuse_with(s.proposals, frame_sigma(s.corners, event, models), [&](Belief& b) { return take_corners(b, s, event.source, models); });
        }
        double operator()(const RangeObservation& o) const {
            if (!hear(track, o, models)) return 0;
            const auto& beacon = models.site.beacons[static_cast<std::size_t>(o.beacon)].position;
            const RangeSource source = learned(models.receiver(track.robot, o.receiver), track.noise.receiver);
            return by_own_sense([&](Belief& b) -> std::optional<Innovation> { return update_range(b, o, beacon, source); });
        }
        double operator()(const RangeDifferenceObservation& o) const {
            if (!hear(track, o, models)) return 0;
            const auto& first = models.site.beacons[static_cast<std::size_t>(o.beacons[0])].position;
            const auto& second = models.site.beacons[static_cast<std::size_t>(o.beacons[1])].position;
            const RangeSource source = learned(models.receiver(track.robot, o.receiver), track.noise.receiver);
            return by_own_sense([&](Belief& b) -> std::optional<Innovation> { return update_difference(b, o, first, second, source); });
        }
        double operator()(const SightingObservation& o) const {
            if (!hear(track, o, models)) return 0;
            const DetectorSource source = learned(models.detectors[static_cast<std::size_t>(track.robot)], track.noise);
            return by_own_sense([&](Belief& b) { return update_sighting(b, o, models.marks, source, models.settings.outliers); });
        }
        double operator()(const PlaceSighting& s) const {
            if (track.alive()) take_places(track, s, models);
            if (!track.alive() && !s.proposals.empty()) start(track, s.proposals, event.time, models);
            return 0;
        }
        double operator()(const AbsenceObservation&) const { return 0; }
        double operator()(const TimePassed&) const { return 0; }
    };
    return std::visit(Visitor{track, event, models, fuse, own_sense}, event.what);
}

}  // namespace roomfix
