#include "roomfix/estimate/track.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "roomfix/estimate/iterated_update.hpp"

namespace roomfix {
namespace {

constexpr double moving_speed = 0.15;     // m/s: faster, the direction of motion tells which end is the front
constexpr double memory_of_health = 2;    // s: so long a source may be wrong
constexpr double longest_judged = 1;      // s that one observation speaks for, at most
constexpr double confirmed_within = 2.0;  // s: so old may another source's word be to judge by
constexpr double sure_enough = 0.2;       // m: a place known less judges nobody
constexpr double front_doubt = 0.02;      // weight of other fronts where the robot seems to drive backwards or sideways
constexpr double vague_yaw = 0.5;         // rad, 1 sigma: a direction seen no better is as good as none to start from
constexpr int yaw_starts = 12;            // of a robot with odometry whose front nobody knows

constexpr double unknown_scale = 0.1;       // of wheels of which nobody knows how they err: standard deviation of both scales
constexpr double well_known = 0.04;         // ... and once it has been learned
constexpr double search_again = 5;          // s between searches for one whose senses contradict where it should be
constexpr double memory_of_agreement = 20;  // observations
constexpr double disagreement = 0.25;       // mean probability of being right: less, and its place is sought anew
constexpr std::size_t enough_heard = 20;
constexpr std::size_t kept_heard = 60;
constexpr std::size_t kept_before_start = 400;

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

Belief start_belief(const PlaceProposal& place, int robot, const TrackingModels& models) {
    Eigen::Matrix3d covariance = place.covariance;
    if (!place.yaw_known) {
        covariance.row(2).setZero();
        covariance.col(2).setZero();
        covariance(2, 2) = unknown_yaw_variance;
    }
    const TrackerSettings& settings = models.settings;
    Belief belief = belief_at(place.pose, covariance, settings.start_speed, settings.start_turning, models.odometry[static_cast<std::size_t>(robot)]);
    for (int i = 0; i < 3 && place.late != 0; ++i) {  // it was there then, and moves as nobody knows yet
        const double variance = belief.covariance(state_vx + i, state_vx + i);
        belief.covariance(i, i) += place.late * place.late * variance;
        belief.covariance(i, state_vx + i) = belief.covariance(state_vx + i, i) = -place.late * variance;
    }
    return belief;
}

/// What was learned about odometry and sensors goes along to a new place.
void keep_learned(Belief& fresh, const Belief& old) {
    const int learned = old.size - state_scale;
    fresh.size = old.size;
    fresh.slow = old.slow;
    fresh.mean.segment(state_scale, learned) = old.mean.segment(state_scale, learned);
    for (int i = state_scale; i < old.size; ++i) {
        fresh.covariance.row(i).head(old.size).setZero();
        fresh.covariance.col(i).head(old.size).setZero();
    }
    fresh.covariance.block(state_scale, state_scale, learned, learned) = old.covariance.block(state_scale, state_scale, learned, learned);
}

/// Places become hypotheses; one without a yaw is tried in all directions where odometry could tell them apart.
void add_places(Track& track, const std::vector<PlaceProposal>& places, double share, const TrackingModels& models) {
    const bool drives = !models.driven[static_cast<std::size_t>(track.robot)].empty();
    double sum = 0;
    for (const PlaceProposal& place : places) sum += place.weight;
    const bool fresh = track.belief.hypotheses.empty();
    const Belief* old = fresh ? nullptr : &track.belief.hypotheses.front().belief;
    std::vector<Hypothesis> added;
    for (const PlaceProposal& place : places) {
        const int turns = !place.yaw_known && drives ? yaw_starts : 1;
        for (int i = 0; i < turns; ++i) {
            Belief belief = start_belief(place, track.robot, models);
            if (turns > 1) {
                const double step = 2 * std::numbers::pi / turns;
                belief.mean[state_yaw] = i * step;
                belief.covariance(state_yaw, state_yaw) = 0.25 * step * step;
            }
            if (old) keep_learned(belief, *old);
            added.push_back({belief, std::log(place.weight / sum / turns), track.time});
        }
    }
    for (Hypothesis& h : added) {
        const bool known = std::any_of(track.belief.hypotheses.begin(), track.belief.hypotheses.end(),
                                       [&](const Hypothesis& other) { return pose_distance(other.belief, h.belief) < 9; });
        if (!fresh && known) continue;
        h.log_weight += std::log(share);
        if (track.belief.hypotheses.size() < most_hypotheses) track.belief.hypotheses.push_back(h);
    }
    settle(track.belief);
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

std::optional<LearnedError> learned_error(const SlowState& slow, const Track& track, const TrackingModels& models) {
    constexpr int of_all = -1;
    const bool detected = slow.source >= of_detector;
    const DetectorSource detector = learned(models.detectors[static_cast<std::size_t>(track.robot)], track.noise);
    const RangeSource receiver = learned(models.receiver(track.robot, detected ? 0 : slow.source), track.noise.receiver);
    const StretchErrors& stretch = detected ? detector.stretch : receiver.stretch;
    const double with_place = 1 / (detected ? detector.wander_way : receiver.wander_way);
    switch (slow.kind) {
        case SlowKind::range_bias:
            if (slow.component == of_all) return LearnedError{detected ? detector.range_common : receiver.bias_sigma};
            return LearnedError{detected ? detector.range_own : receiver.own_sigma};
        case SlowKind::range_wander:
            if (slow.component == of_all) return LearnedError{detected ? detector.range_sway : receiver.sway_sigma, with_place};
            return LearnedError{detected ? detector.range_wander : receiver.wander_sigma, with_place};
        case SlowKind::range_scale:
            return LearnedError{stretch.scale};
        case SlowKind::range_direction:
            return LearnedError{stretch.direction};
        case SlowKind::range_curve:
            return LearnedError{stretch.curve};
        case SlowKind::bearing_shape:
            return LearnedError{detector.bearing_shape};
        case SlowKind::bearing_bias:
            return LearnedError{detector.bearing_common};
        case SlowKind::bearing_wander:
            return LearnedError{detector.bearing_sway, with_place};
        default:
            return std::nullopt;
    }
}

std::string why_not_found(const Track& track, const TrackingModels& models) {
    if (track.cloud.empty()) return "nothing was heard or seen of it";
    const StartPlaces found = track.cloud.places(models.settings.start_patience);
    return found.reason.empty() ? "it was found only at the very end" : found.reason;
}

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

bool is_missing(const Track& track, const TrackerSettings& settings) { return track.absence < std::log(settings.surprise / (1 - settings.surprise)); }

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

void start(Track& track, const std::vector<PlaceProposal>& places, Nanoseconds time, const TrackingModels& models) {
    track.belief.hypotheses.clear();
    track.time = track.born = track.seen = time;
    track.absence = 0;
    track.sightings = 1;
    track.budget = most_budget;
    track.cloud = {};
    track.doubt.setZero();
    add_places(track, places, 1, models);
}

void list_places(const PoseObservation& observation, std::vector<PlaceProposal>& places) {
    places.clear();
    const bool yaw_known = observation.yaw_known && observation.covariance(2, 2) < vague_yaw * vague_yaw;
    const int turns = yaw_known ? std::max(observation.like_turns, 1) : 1;
    for (int i = 0; i < turns; ++i) {
        const double yaw = wrap_angle(observation.pose.yaw + 2 * std::numbers::pi * i / turns);
        places.push_back({{observation.pose.x, observation.pose.y, yaw}, observation.covariance, yaw_known, 1, observation.late});
    }
}

std::vector<PlaceProposal> places_of(const PoseObservation& observation) {
    std::vector<PlaceProposal> places;
    list_places(observation, places);
    return places;
}

/// A body that looks the same from several sides, and drives another way than it faces: perhaps it faces that way.
void doubt_the_front(Track& track, const PoseObservation& observation, const TrackingModels& models) {
    if (observation.like_turns < 2 || track.belief.hypotheses.size() > 1 || models.motion[static_cast<std::size_t>(track.robot)].drive == Drive::holonomic)
        return;
    const Belief& belief = track.belief.best();
    const Eigen::Vector2d velocity = belief.mean.segment<2>(state_vx);
    const double forward = belief.forward_speed();
    const double turn = 2 * std::numbers::pi / observation.like_turns;
    if (velocity.norm() < moving_speed || forward > velocity.norm() * std::cos(0.75 * turn)) return;
    add_places(track, places_of(observation), front_doubt, models);
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
    doubt_the_front(track, observation, models);
    face_each_way(track, observation);
    const PoseSource& errors = models.fixed.at(source);
    OutlierModel outliers = outlier_model(observation.yaw_known ? 3 : 2, models.settings);
    if (certain) outliers.gate = std::numeric_limits<double>::infinity();
    thread_local std::vector<PlaceProposal> places;
    list_places(observation, places);
    return take_with(track, source, places, models, [&](Belief& belief) -> std::optional<Innovation> {
        add_slow_states(belief, observation, errors);
        if (!observation.yaw_known) return update(belief, linearise_place(belief, observation, errors), outliers);
        return update(belief, linearise_pose(belief, observation, errors), outliers);
    });
}

/// Noise of the robot's senses as the search for its place found it: larger than stated, and partly the same for all.
void expect_errors(RangeErrors& errors, double found, double stated) {
    constexpr double much = 1.5;  // times what is stated: less is chance
    if (found < much * stated) return;
    errors.factor = std::max(errors.factor, found / stated);
    errors.common = std::max(errors.common, found);
    errors.own = std::max(errors.own, 0.5 * found);
    errors.wander = std::max(errors.wander, 0.5 * found);
}

/// Did the robot's own senses find it, and not a camera? Only then they are doubted and may look for it again.
bool found_by_senses(const Track& track) { return track.seeks && track.searched != never; }

/// How its wheels err as far as that has been learned.
WheelErrors wheels_of(const Track& track) {
    const Belief& best = track.belief.best();
    const bool learned = best.covariance(state_turn_scale, state_turn_scale) < well_known * well_known;
    return {best.mean[state_scale], best.mean[state_turn_scale], best.mean[state_drift], track.noise.delay, learned};
}

bool sees_depths(const Track& track) { return track.noise.receiver.stretch.depth > 0 || track.noise.detector.stretch.depth > 0; }

void doubt_wheels(OdometryPrior& wheels) {
    wheels.scale_sigma = std::max(wheels.scale_sigma, unknown_scale);
    wheels.turn_scale_sigma = std::max(wheels.turn_scale_sigma, unknown_scale);
}

void doubt_wheels(Track& track) {
    for (Hypothesis& h : track.belief.hypotheses) {
        for (const int state : {state_scale, state_turn_scale}) {
            double& variance = h.belief.covariance(state, state);
            variance = std::max(variance, unknown_scale * unknown_scale);
        }
    }
}

/// Starts a track where its own senses put it. `depth`: its ranges are depths.
void start_by_senses(Track& track, const std::vector<PlaceProposal>& places, bool depth, Nanoseconds time, const TrackingModels& models) {
    start(track, places, time, models);
    track.noise.receiver.stretch.depth = track.noise.detector.stretch.depth = depth ? 1 : 0;
    doubt_wheels(track);
}

Track started_elsewhere(const Track& track, const PlaceProposal& place, bool depth, const TrackingModels& models) {
    Track other = track;
    start_by_senses(other, {place}, depth, track.time, models);
    return other;
}

/// What its senses say cannot be, by what was believed: it is known less well than that. Its wheels slipped, most often.
void widen(Track& track) {
    constexpr double wider = 9;                                          // times the variances
    const Eigen::Vector3d least(0.05 * 0.05, 0.05 * 0.05, 0.05 * 0.05);  // m^2, m^2, rad^2
    for (Hypothesis& h : track.belief.hypotheses) {
        auto pose = h.belief.covariance.topLeftCorner<3, 3>();
        pose *= wider;
        pose.diagonal() += least;
    }
}

/// Its senses contradict where it should be: it may have slipped, or perhaps they put it elsewhere.
void find_again(Track& track, const TrackingModels& models) {
    if (!models.settings.learns || !found_by_senses(track) || to_seconds(track.time - track.searched) < search_again || track.heard.size() < enough_heard)
        return;
    track.searched = track.time;
    track.agreement = 1;
    widen(track);
    StartCloud cloud(wheels_of(track), sees_depths(track));
    for (const Heard& heard : track.heard) cloud.take(heard, track.robot, models);
    const StartPlaces found = cloud.places(0);
    if (!found.places.empty()) add_places(track, found.places, models.settings.kidnapping, models);
}

double distance_of(const RangeObservation& o) { return o.range; }
double distance_of(const RangeDifferenceObservation& o) { return std::abs(o.difference); }
double distance_of(const SightingObservation& o) { return o.range.value_or(2); }

/// Landmarks whose names are not told look alike in many places: until these have been compared (noise_learner.hpp), none of them is a fix.
Eigen::Matrix3d anywhere_in(const Site& site) {
    return Eigen::Vector3d(std::pow(3 * site.lost, 2), std::pow(3 * site.lost, 2), unknown_yaw_variance).asDiagonal();
}

/// Keeps what a robot heard. False where it is not to be taken in: nobody knows yet where the robot is. As soon as that can be told the track starts there.
template <class Observation>
bool hear(Track& track, const Observation& o, const TrackingModels& models) {
    const std::size_t most = track.alive() ? kept_heard : kept_before_start;
    if (track.heard.size() >= most) track.heard.erase(track.heard.begin(), track.heard.end() - static_cast<std::ptrdiff_t>(most / 2));
    track.heard.push_back(o);
    if (track.alive()) {
        const bool drives = !models.driven[static_cast<std::size_t>(track.robot)].empty();
        if (found_by_senses(track)) split_vague(track.belief, widest_place(distance_of(o)), drives ? widest_front : unknown_yaw_variance);
        return true;
    }
    track.cloud.take(o, track.robot, models);
    const StartPlaces found = track.cloud.places(models.settings.start_patience);
    if (found.places.empty()) return false;
    start_by_senses(track, found.places, found.depth, o.time, models);
    track.noise.way = track.noise.turn = models.settings.unknown_wheels;
    if constexpr (std::is_same_v<Observation, SightingObservation>) {
        if (o.range) expect_errors(track.noise.detector, found.error, o.range_sigma);
        if (o.range) track.noise.detector.sway = o.range_sigma;
        if (o.bearing) track.noise.bearing_sway = o.bearing_sigma;
        if (o.landmark < 0) track.doubt = anywhere_in(models.site);
    } else {
        track.noise.receiver.wander = o.sigma;
        expect_errors(track.noise.receiver, found.error, o.sigma);
    }
    track.agreement = 1;
    track.searched = o.time;
    return false;
}

/// Is a sighting that names places to be the track's start? At first, after so long unseen that what is believed says nothing, and where it is not seen
/// although it should be.
bool begins(const Track& track, const TrackingModels& models) {
    return !track.alive() || track.belief.best().place_sigma() > models.settings.anywhere || is_missing(track, models.settings);
}

double take(Track& track, const Event& event, const TrackingModels& models) {
    const auto fuse = [&](const std::vector<PlaceProposal>& proposals, const auto& update_one) {
        if (track.alive() && (proposals.empty() || !begins(track, models))) return take_with(track, event.source, proposals, models, update_one);
        if (!proposals.empty()) {
            start(track, proposals, event.time, models);
            health_of(track, event.source).seen = event.time;
        }
        return 0.0;
    };
    const auto own_sense = [&](const auto& update_one) {
        double right = 0;
        const double evidence = take_with(track, event.source, {}, models, update_one, &right);
        track.evidence += evidence;
        ++track.weighed;
        track.agreement += (right - track.agreement) / memory_of_agreement;
        if (track.agreement < disagreement) find_again(track, models);
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
            start(track, places_of(o), event.time, models);
            health_of(track, event.source).seen = event.time;
            return 0;
        }
        double operator()(const GroupSighting&) const { return 0; }
        double operator()(const TagSighting& s) const {
            const PoseSource& camera = models.fixed.at(event.source);
            const View& view = models.views.at(event.source);
            const SiteRobot& robot = models.site.robots[static_cast<std::size_t>(s.robot)];
            return fuse_with(s.proposals, [&](Belief& b) {
                add_slow_states(b, camera);
                return iterated_update<8>(b, outlier_model_over(8, 100, models.settings),
                                          [&](const Belief& at) { return linearise_tag(at, s.corners, view, robot, camera); });
            });
        }
        double operator()(const LandmarkSighting& s) const {
            return fuse_with(s.proposals, [&](Belief& b) { return take_landmarks(b, s, event.source, models); });
        }
        double operator()(const CornerSighting& s) const {
            return fuse_with(s.proposals, [&](Belief& b) { return take_corners(b, s, event.source, models); });
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
