#include "roomfix/estimate/own_senses.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/estimate/track_start.hpp"

namespace roomfix {
namespace {

constexpr double unknown_scale = 0.1;  // of wheels of which nobody knows how they err: standard deviation of both scales
constexpr double well_known = 0.04;    // ... and once it has been learned
constexpr double search_again = 5;     // s between searches for one whose senses contradict where it should be
constexpr std::size_t enough_heard = 20;
constexpr std::size_t kept_heard = 60;
constexpr std::size_t kept_before_start = 400;
constexpr double memory_of_agreement = 20;  // observations
constexpr double disagreement = 0.25;       // mean probability of being right: less, and its place is sought anew

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

double distance_of(const RangeObservation& o) { return o.range; }
double distance_of(const RangeDifferenceObservation& o) { return std::abs(o.difference); }
double distance_of(const SightingObservation& o) { return o.range.value_or(2); }

/// Landmarks whose names are not told look alike in many places: until these have been compared (noise_learner.hpp), none of them is a fix.
Eigen::Matrix3d anywhere_in(const Site& site) {
    return Eigen::Vector3d(std::pow(3 * site.lost, 2), std::pow(3 * site.lost, 2), unknown_yaw_variance).asDiagonal();
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

template <class Observation>
bool keep_heard(Track& track, const Observation& o, const TrackingModels& models) {
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

}  // namespace

bool hear(Track& track, const RangeObservation& o, const TrackingModels& models) { return keep_heard(track, o, models); }
bool hear(Track& track, const RangeDifferenceObservation& o, const TrackingModels& models) { return keep_heard(track, o, models); }
bool hear(Track& track, const SightingObservation& o, const TrackingModels& models) { return keep_heard(track, o, models); }

void note_agreement(Track& track, double right, const TrackingModels& models) {
    track.agreement += (right - track.agreement) / memory_of_agreement;
    if (track.agreement < disagreement) find_again(track, models);
}

bool sees_depths(const Track& track) { return track.noise.receiver.stretch.depth > 0 || track.noise.detector.stretch.depth > 0; }

void doubt_wheels(OdometryPrior& wheels) {
    wheels.scale_sigma = std::max(wheels.scale_sigma, unknown_scale);
    wheels.turn_scale_sigma = std::max(wheels.turn_scale_sigma, unknown_scale);
}

Track started_elsewhere(const Track& track, const PlaceProposal& place, bool depth, const TrackingModels& models) {
    Track other = track;
    start_by_senses(other, {place}, depth, track.time, models);
    return other;
}

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

}  // namespace roomfix
