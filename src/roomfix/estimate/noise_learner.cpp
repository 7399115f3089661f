#include "roomfix/estimate/noise_learner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "roomfix/estimate/own_senses.hpp"

namespace roomfix {
namespace {

constexpr double first_wait = 8;      // s until it is learned for the first time, then after twice as long, ...
constexpr double longest_wait = 256;  // s
constexpr std::size_t least_events = 40;
constexpr std::size_t most_events = 3000;
constexpr double doubted = 260;  // s: so long after the start it is asked whether it was elsewhere
// Nats that a rival may be behind before its own noise is sought.
constexpr double least_promise = 10, promise_per_event = 0.5;
constexpr double clearly_better = 3;  // nats
constexpr double same_place = 9;      // squared distance: two that are nearer to each other are one

SensedKinds kinds_of(const std::vector<Event>& events, int robot, const TrackingModels& models) {
    SensedKinds kinds;
    kinds.wheels = !models.driven[static_cast<std::size_t>(robot)].empty();
    for (const Event& event : events) {
        if (const auto* range = std::get_if<RangeObservation>(&event.what)) {
            kinds.ranges = true;
            kinds.range_sigma = range->sigma;
        }
        if (const auto* difference = std::get_if<RangeDifferenceObservation>(&event.what)) {
            kinds.ranges = true;
            kinds.range_sigma = difference->sigma;
        }
        if (const auto* sighting = std::get_if<SightingObservation>(&event.what)) {
            kinds.sighted_ranges |= sighting->range.has_value();
            kinds.bearings |= sighting->bearing.has_value();
            kinds.sighted_sigma = sighting->range_sigma;
            kinds.bearing_sigma = sighting->bearing_sigma;
        }
    }
    return kinds;
}

std::optional<Heard> heard_in(const Event& event) {
    if (const auto* range = std::get_if<RangeObservation>(&event.what)) return *range;
    if (const auto* difference = std::get_if<RangeDifferenceObservation>(&event.what)) return *difference;
    if (const auto* sighting = std::get_if<SightingObservation>(&event.what)) return *sighting;
    return std::nullopt;
}

/// Slow states of kinds that were learned take on their new variance.
void adopt(Track& track, const TrackingModels& models) {
    for (Hypothesis& h : track.belief.hypotheses) {
        for (std::size_t i = 0; i < h.belief.slow.size(); ++i) {
            SlowState& slow = h.belief.slow[i];
            const auto error = learned_error(slow, track, models);
            if (!error) continue;
            slow.per_metre = error->per_metre;
            const int state = core_states + static_cast<int>(i);
            // It cannot be known worse than before anything was known.
            const double now = h.belief.covariance(state, state);
            const double variance = std::max(error->sigma * error->sigma, 1e-10);
            if (now > variance) {
                const double shrink = std::sqrt(variance / now);
                h.belief.covariance.row(state).head(h.belief.size) *= shrink;
                h.belief.covariance.col(state).head(h.belief.size) *= shrink;
                h.belief.mean[state] *= shrink;
            } else if (variance > slow.variance) {
                h.belief.covariance(state, state) += now / slow.variance * (variance - slow.variance);
            }
            slow.variance = variance;
        }
    }
}

}  // namespace

void NoiseLearner::begin(const Track& track) {
    const bool again = begun_ && origin_.born == track.born;
    wait_ = again ? std::max(0.25 * wait_, first_wait) : first_wait;
    if (!again) before_.reset();
    if (again && learned_once_) before_ = noise_;
    begun_ = true;
    learned_once_ = false;
    origin_ = track;
    if (before_) origin_.noise = *before_;
    noise_ = first_noise_ = track.noise;
    events_.clear();
    learned_ = track.time;
}

void NoiseLearner::add(const Event& event) {
    if (event.time <= origin_.time) return;
    events_.insert(std::upper_bound(events_.begin(), events_.end(), event), event);
}

Nanoseconds NoiseLearner::reach() const {
    if (!begun_) return never;
    return origin_.heard.empty() ? origin_.time : std::min(origin_.time, time_of(origin_.heard.front()));
}

bool NoiseLearner::due(Nanoseconds until) const { return begun_ && events_.size() >= least_events && to_seconds(until - learned_) >= wait_; }

/// Log density of the first `count` events, from an origin. `end` receives the track after them.
double NoiseLearner::evidence(const Track& origin, const SenseNoise& noise, std::size_t count, const TrackingModels& models, Track* end) const {
    Track track = origin;
    track.noise = noise;
    track.seeks = false;
    track.cloud = {};
    adopt(track, models);
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
        predict(track, events_[i].time, models);
        const double density = take(track, events_[i], models);
        if (news_[i]) sum += density;
    }
    if (end == nullptr) return sum;
    *end = track;
    end->seeks = true;
    return sum;
}

Track NoiseLearner::learn(Nanoseconds until, const TrackingModels& models) {
    const auto last = std::upper_bound(events_.begin(), events_.end(), until, [](Nanoseconds t, const Event& e) { return t < e.time; });
    const auto count = static_cast<std::size_t>(last - events_.begin());
    find_what_is_new(count, models);
    const SensedKinds kinds = kinds_of(events_, origin_.robot, models);
    const NoiseSearch::Evidence evidence_here = [&](const SenseNoise& noise) { return evidence(origin_, noise, count, models, nullptr); };
    const NoiseSearch search(kinds, before_, evidence_here);
    NoiseSearch::Result found = search.best(origin_.noise);
    std::vector<Rival> rivals;
    if (to_seconds(until - origin_.born) < doubted && origin_.born == origin_.belief.placed()) rivals = compare_rivals(found, kinds, count, models);
    origin_.noise = found.noise;  // where the next search starts
    Track end;
    evidence(origin_, search.widened(found), count, models, &end);
    end.doubt = doubt_of(end, found.log_density, rivals, count, models);
    learned_ = until;
    learned_once_ = true;
    wait_ = std::min(2 * wait_, longest_wait);
    noise_ = found.noise;
    if (count > most_events) forget(count - most_events / 2, models);
    return end;
}

/// Was the start elsewhere? Then the origin becomes another one, and `found` its noise. The most promising rivals get a noise of their own. Returns all
/// that are not the origin now, the likeliest first.
std::vector<NoiseLearner::Rival> NoiseLearner::compare_rivals(NoiseSearch::Result& found, const SensedKinds& kinds, std::size_t count,
                                                              const TrackingModels& models) {
    constexpr std::size_t tried = 2;  // of those whose ranges are distances, and of those whose ranges are depths: each has a noise of its own
    const auto search_from = [&](const Track& track, const auto& use) {
        const NoiseSearch::Evidence evidence_there = [&](const SenseNoise& noise) { return evidence(track, noise, count, models, nullptr); };
        use(NoiseSearch(kinds, before_, evidence_there));
    };
    std::vector<Rival> all;
    std::vector<Track> starts = rivals(count, models);
    for (const Track& track : rivals_anywhere(count, models)) starts.push_back(track);
    for (const Track& track : starts) {
        search_from(track, [&](const NoiseSearch& search) {
            SenseNoise like_ours = found.noise;
            like_ours.receiver.stretch.depth = track.noise.receiver.stretch.depth;
            like_ours.detector.stretch.depth = track.noise.detector.stretch.depth;
            for (const SenseNoise& noise : {track.noise, like_ours}) all.push_back({track, {noise, search.log_density(noise)}});
        });
    }
    const auto likelier = [](const Rival& a, const Rival& b) { return a.result.log_density > b.result.log_density; };
    std::stable_sort(all.begin(), all.end(), likelier);
    const double promising = least_promise + promise_per_event * static_cast<double>(count);
    std::array<std::vector<Belief>, 2> sought;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i].result.log_density < found.log_density - promising) break;
        const Belief& start = all[i].track.belief.best();
        std::vector<Belief>& alike = sought[sees_depths(all[i].track) ? 1 : 0];
        if (alike.size() == tried || std::any_of(alike.begin(), alike.end(), [&](const Belief& other) { return pose_distance(other, start) < same_place; }))
            continue;
        alike.push_back(start);
        search_from(all[i].track, [&](const NoiseSearch& search) {
            all[i].result = search.best(all[i].result.noise);
            if (all[i].result.log_density < found.log_density + clearly_better) return;
            std::swap(found, all[i].result);
            std::swap(origin_, all[i].track);
        });
    }
    std::stable_sort(all.begin(), all.end(), likelier);
    return all;
}

/// How far rivals that are nearly as likely have come from where the track has: their spread about it, each by its weight.
Eigen::Matrix3d NoiseLearner::doubt_of(const Track& end, double log_density, const std::vector<Rival>& rivals, std::size_t count,
                                       const TrackingModels& models) const {
    constexpr double out_of_the_question = 7;  // nats
    // What is sensed errs in ways that no noise here describes, and for long in the same: of what makes one place likelier than another so much is believed.
    constexpr double believed = 0.33;
    constexpr std::size_t most = 6;
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    double weights = 1;
    std::vector<Belief> others = {end.belief.best()};
    for (const Rival& rival : rivals) {
        if (others.size() > most || believed * (rival.result.log_density - log_density) < -out_of_the_question) break;
        Track there;
        evidence(rival.track, rival.result.noise, count, models, &there);
        if (!there.alive()) continue;
        const Belief& other = there.belief.best();
        if (std::any_of(others.begin(), others.end(), [&](const Belief& known) { return pose_distance(known, other) < same_place; })) continue;
        others.push_back(other);
        const double weight = std::exp(std::min(believed * (rival.result.log_density - log_density), 0.0));
        Eigen::Vector3d off = other.mean.head<3>() - end.belief.best().mean.head<3>();
        off.z() = wrap_angle(off.z());
        weights += weight;
        spread += weight * (off * off.transpose() + other.pose_covariance());
    }
    return spread / weights;
}

/// The track as it would be had it started elsewhere: where the robot may have been then, by all that was sensed until now.
std::vector<Track> NoiseLearner::rivals(std::size_t count, const TrackingModels& models) const {
    constexpr std::uint64_t seeds = 2;
    constexpr std::size_t enough = 600;  // events that tell where it was
    std::vector<Track> all;
    for (const bool depth : {false, true}) {
        for (std::uint64_t seed = 2; seed < 2 + seeds; ++seed) {
            StartCloud cloud(WheelErrors{}, depth, seed);
            for (const Heard& heard : origin_.heard) cloud.take(heard, origin_.robot, models);
            cloud.mark();
            for (std::size_t i = 0; i < std::min(count, enough); ++i) {
                if (const auto heard = heard_in(events_[i])) cloud.take(*heard, origin_.robot, models);
            }
            for (const PlaceProposal& place : cloud.marked()) all.push_back(started_elsewhere(origin_, place, depth, models));
        }
    }
    return all;
}

/// The same, wherever it can have been: the more of them have to be followed, the fewer events they are compared by at first.
std::vector<Track> NoiseLearner::rivals_anywhere(std::size_t count, const TrackingModels& models) const {
    constexpr std::size_t first_events = 12, enough = 400, left = 5, kept_of = 3;
    constexpr double nearby = 1;  // s: by what was heard so near to the origin's time
    std::optional<Heard> nearest;
    const auto offer = [&](const Heard& heard) {
        const auto away = [&](const Heard& h) { return std::abs(to_seconds(time_of(h) - origin_.time)); };
        if (away(heard) < nearby && (!nearest || away(heard) < away(*nearest))) nearest = heard;
    };
    for (const Heard& heard : origin_.heard) offer(heard);
    for (std::size_t i = 0; i < std::min(count, first_events); ++i) {
        if (const auto heard = heard_in(events_[i])) offer(*heard);
    }
    if (!nearest) return {};
    struct Candidate {
        PlaceProposal place;
        bool depth = false;
        double log_density = 0;
    };
    Track unlearned = origin_;
    unlearned.noise = first_noise_;
    const auto started = [&](const Candidate& candidate) { return started_elsewhere(unlearned, candidate.place, candidate.depth, models); };
    std::vector<Candidate> candidates;
    for (const bool depth : {false, true}) {
        for (const PlaceProposal& place : likely_places(places_around(*nearest, depth, models), *nearest, count, depth, models)) {
            candidates.push_back({place, depth});
        }
    }
    for (std::size_t compared = first_events; candidates.size() > left; compared *= 2) {
        const std::size_t some = std::min({compared, count, enough});
        for (Candidate& candidate : candidates) {
            const Track track = started(candidate);
            candidate.log_density = evidence(track, track.noise, some, models, nullptr);
        }
        std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.log_density > b.log_density; });
        candidates.resize(std::max(left, some < std::min(count, enough) ? candidates.size() / kept_of : left));
    }
    std::vector<Track> tracks;
    for (const Candidate& candidate : candidates) tracks.push_back(started(candidate));
    return tracks;
}

/// Of very many places, as there are around many landmarks that look alike, those that explain best what was seen at about that time.
std::vector<PlaceProposal> NoiseLearner::likely_places(std::vector<PlaceProposal> places, const Heard& heard, std::size_t count, bool depth,
                                                       const TrackingModels& models) const {
    constexpr std::size_t most = 400;
    constexpr double about = 1;                          // s
    constexpr double bearing_error = 0.13, part = 0.08;  // rad, of the range: as far as places lie apart
    constexpr double unexplained = 9;                    // squared distance of what no landmark explains
    if (places.size() <= most) return places;
    std::vector<SightingObservation> sightings;
    for (std::size_t i = 0; i < count && to_seconds(events_[i].time - time_of(heard)) < about; ++i) {
        const auto* seen = std::get_if<SightingObservation>(&events_[i].what);
        if (seen != nullptr && seen->range && seen->bearing) sightings.push_back(*seen);
    }
    const auto distance = [&](const SightingObservation& seen, const Pose2& pose, const Mark& mark) {
        const PredictedSighting there = predict_sighting(pose, Eigen::Vector2d::Zero(), mark.place);
        const double range = there.range * (depth ? std::cos(there.bearing) : 1);
        return std::pow(wrap_angle(there.bearing - *seen.bearing) / bearing_error, 2) + std::pow((range - *seen.range) / (part * *seen.range), 2);
    };
    std::vector<std::pair<double, std::size_t>> order;  // how badly it explains what was seen, which place
    for (std::size_t k = 0; k < places.size(); ++k) {
        double sum = 0;
        for (const SightingObservation& seen : sightings) {
            double least = unexplained;
            for (const Mark& mark : models.marks) least = std::min(least, distance(seen, places[k].pose, mark));
            sum += least;
        }
        order.emplace_back(sum, k);
    }
    std::sort(order.begin(), order.end());
    std::vector<PlaceProposal> likely;
    for (std::size_t k = 0; k < most; ++k) likely.push_back(places[order[k].second]);
    return likely;
}

/// A robot that stands sees the same again, with the same error: a distance that is read off as so many pixels comes out the same each time, which says
/// nothing of how it errs elsewhere. So a landmark counts again when the robot has moved; without a name nobody knows whether it is the same.
void NoiseLearner::find_what_is_new(std::size_t count, const TrackingModels& models) {
    constexpr double moved = 0.02, turned = 0.03;  // m, rad: then it is another error
    const OdometryTrack& driven = models.driven[static_cast<std::size_t>(origin_.robot)];
    news_.assign(count, true);
    if (driven.empty()) return;
    std::set<int> seen;  // landmarks, since it stands
    Nanoseconds since = origin_.time;
    for (std::size_t i = 0; i < count; ++i) {
        const auto* sighting = std::get_if<SightingObservation>(&events_[i].what);
        if (sighting == nullptr || sighting->landmark < 0) continue;
        const auto step = driven.step(since, sighting->time);
        if (!step || step->way.norm() > moved || std::abs(step->turned) > turned) {
            seen.clear();
            since = sighting->time;
        }
        news_[i] = seen.insert(sighting->landmark).second;
    }
}

/// Moves the origin on past the first `count` events.
void NoiseLearner::forget(std::size_t count, const TrackingModels& models) {
    Track later;
    evidence(origin_, origin_.noise, count, models, &later);
    origin_ = later;
    events_.erase(events_.begin(), events_.begin() + static_cast<std::ptrdiff_t>(count));
}

}  // namespace roomfix
