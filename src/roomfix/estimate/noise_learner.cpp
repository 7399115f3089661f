#include "roomfix/estimate/noise_learner.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr double first_wait = 8;      // s until it is learned for the first time, then after twice as long, ...
constexpr double longest_wait = 256;  // s
constexpr std::size_t least_events = 40;
constexpr std::size_t most_events = 3000;
constexpr double usual_wheels = 2;      // times the random errors of good wheels
constexpr double spread_of_wheels = 1;  // of its logarithm
constexpr double way_like_turn = 0.7;   // by so much the logarithms of their errors of way and turning differ
constexpr double usual_delay = 0.3;     // s, between what wheels say and what the robot does
constexpr double shift = 0.1;           // s, of the delay in the first steps
constexpr double cost_of_an_error = 3;  // nats: a kind of error that explains less is left out

/// One number of the noise that is sought.
struct Unknown {
    double* value;
    double from_nothing = 0;  // what to try where it is 0; 0: it is never 0
    double usual = 1;         // its logarithm is normally distributed around that of this ...
    double spread = 1.5;      // ... with this standard deviation; 0: anything alike
    double least = 0.05, most = 50;
    bool known = false;  // there was such an error when it was learned before

    double log_prior() const {
        if (from_nothing > 0 && *value == 0) return known ? -cost_of_an_error : 0;
        const double z = std::log(*value / usual) / spread;
        return -0.5 * z * z - (from_nothing > 0 && !known ? cost_of_an_error : 0);
    }
};

/// What the events are about.
struct Kinds {
    bool ranges = false, sighted_ranges = false, bearings = false, wheels = false;
    double range_sigma = 0.02, sighted_sigma = 0.05, bearing_sigma = 0.01;
};

Kinds kinds_of(const std::vector<Event>& events, int robot, const TrackingModels& models) {
    Kinds kinds;
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

void add_ranges(RangeErrors& errors, double sigma, std::vector<Unknown>& unknowns) {
    const double now = errors.factor * sigma;
    unknowns.push_back({&errors.factor});
    unknowns.push_back({&errors.wander, now});
    unknowns.push_back({&errors.sway, now});
    unknowns.push_back({&errors.own, now});
    unknowns.push_back({&errors.common, 2 * now});
    for (std::size_t i = unknowns.size() - 4; i < unknowns.size(); ++i) {
        unknowns[i].usual = sigma;
        unknowns[i].spread = 1;
        unknowns[i].least = 0.05 * sigma;
        unknowns[i].most = 1000 * sigma;
    }
    unknowns[unknowns.size() - 5].most = 1000;
    unknowns.push_back({&errors.stretch.scale, 0.03, 0.02, 0.7, 0.002, 0.3});
    unknowns.push_back({&errors.stretch.direction, 0.05, 0.05, 0.7, 0.005, 0.5});
    unknowns.push_back({&errors.stretch.growth, 0.01, 0.01, 0.7, 0.001, 0.2});
}

std::vector<Unknown> unknowns_of(SenseNoise& noise, const Kinds& kinds) {
    std::vector<Unknown> unknowns;
    if (kinds.wheels) {
        unknowns.push_back({&noise.way, 0, usual_wheels, spread_of_wheels});
        unknowns.push_back({&noise.turn, 0, usual_wheels, spread_of_wheels});
    }
    if (kinds.ranges) add_ranges(noise.receiver, kinds.range_sigma, unknowns);
    if (kinds.sighted_ranges) add_ranges(noise.detector, kinds.sighted_sigma, unknowns);
    if (kinds.bearings) {
        unknowns.push_back({&noise.bearing});
        unknowns.push_back({&noise.bearing_sway, kinds.bearing_sigma, kinds.bearing_sigma, 1, 0.1 * kinds.bearing_sigma, 0.5});
        unknowns.push_back({&noise.bearing_common, kinds.bearing_sigma, kinds.bearing_sigma, 1, 0.1 * kinds.bearing_sigma, 0.5});
    }
    return unknowns;
}

/// What was learned before is not forgotten, only doubted.
void expect(std::vector<Unknown>& unknowns, const std::vector<Unknown>& before) {
    constexpr double doubt = 0.7;  // standard deviation of the logarithm
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
        if (*before[i].value == 0) continue;
        unknowns[i].usual = *before[i].value;
        unknowns[i].spread = std::min(unknowns[i].spread, doubt);
        unknowns[i].known = true;
    }
}

/// Few observations tell little of the noise: each standard deviation becomes the root of its mean square over what it may be (a normal distribution of its
/// logarithm, by the curvature at the best).
template <class Likely>
void widen(std::vector<Unknown>& unknowns, double best, const Likely& likely) {
    constexpr double step = 1.5;
    constexpr double widest = 1;  // of the logarithm's standard deviation
    std::vector<double> wider;
    for (const Unknown& unknown : unknowns) {
        const double before = *unknown.value;
        wider.push_back(before);
        if (before == 0) continue;
        *unknown.value = step * before;
        const double above = likely();
        *unknown.value = before / step;
        const double below = likely();
        *unknown.value = before;
        const double curvature = (2 * best - above - below) / std::pow(std::log(step), 2);
        const double variance = curvature > 0 ? std::min(1 / curvature, widest * widest) : widest * widest;
        wider.back() = before * std::exp(variance);
    }
    for (std::size_t i = 0; i < unknowns.size(); ++i) *unknowns[i].value = wider[i];
}

/// Slow states of kinds that were learned take on their new variance.
void adopt(Track& track, const TrackingModels& models) {
    for (Hypothesis& h : track.belief.hypotheses) {
        for (std::size_t i = 0; i < h.belief.slow.size(); ++i) {
            SlowState& slow = h.belief.slow[i];
            const auto sigma = sigma_of(slow, track, models);
            if (!sigma) continue;
            const int state = core_states + static_cast<int>(i);
            // It cannot be known worse than before anything was known.
            const double now = h.belief.covariance(state, state);
            const double variance = std::max(*sigma * *sigma, 1e-10);
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
    noise_ = track.noise;
    events_.clear();
    learned_ = track.time;
}

void NoiseLearner::add(const Event& event) {
    if (event.time <= origin_.time) return;
    events_.insert(std::upper_bound(events_.begin(), events_.end(), event), event);
}

bool NoiseLearner::due(Nanoseconds until) const { return begun_ && events_.size() >= least_events && to_seconds(until - learned_) >= wait_; }

/// Log density of the first `count` events. `end` receives the track after them.
double NoiseLearner::evidence(const SenseNoise& noise, std::size_t count, const TrackingModels& models, Track* end) const {
    Track track = origin_;
    track.noise = noise;
    track.seeks = false;
    track.cloud = {};
    adopt(track, models);
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
        predict(track, events_[i].time, models);
        sum += take(track, events_[i], models);
    }
    if (end == nullptr) return sum;
    *end = track;
    end->seeks = true;
    return sum;
}

Track NoiseLearner::learn(Nanoseconds until, const TrackingModels& models) {
    const auto last = std::upper_bound(events_.begin(), events_.end(), until, [](Nanoseconds t, const Event& e) { return t < e.time; });
    const auto count = static_cast<std::size_t>(last - events_.begin());
    SenseNoise noise = origin_.noise;
    const Kinds kinds = kinds_of(events_, origin_.robot, models);
    std::vector<Unknown> unknowns = unknowns_of(noise, kinds);
    if (before_) expect(unknowns, unknowns_of(*before_, kinds));
    const double delay = before_ ? before_->delay : 0;
    const auto likely = [&] {
        double sum = evidence(noise, count, models, nullptr);
        for (const Unknown& u : unknowns) sum += u.log_prior();
        return sum - 0.5 * std::pow(std::log(noise.way / noise.turn) / way_like_turn, 2) - 0.5 * std::pow((noise.delay - delay) / usual_delay, 2);
    };
    double best = likely();
    const auto shift_wheels = [&](double by) {
        const double before = noise.delay;
        noise.delay += by;
        const double now = likely();
        if (now > best + 0.05) {
            best = now;
            return true;
        }
        noise.delay = before;
        return false;
    };
    const auto flip = [&](double& depth) {
        depth = 1 - depth;
        const double now = likely();
        if (now > best + (depth > 0 ? cost_of_an_error : -cost_of_an_error)) {
            best = now;
            return;
        }
        depth = 1 - depth;
    };
    for (const double step : {2.0, 2.0, 1.4, 1.2}) {
        bool moved = false;
        if (kinds.ranges) flip(noise.receiver.stretch.depth);
        if (kinds.sighted_ranges) flip(noise.detector.stretch.depth);
        if (kinds.wheels) {
            const double by = shift * (step - 1);
            const bool later = shift_wheels(by);
            for (int i = 0; i < 6 && shift_wheels(later ? by : -by); ++i) moved = true;
            moved |= later;
        }
        for (Unknown& unknown : unknowns) {
            const auto attempt = [&](double tried) {
                if (tried > unknown.most) return false;
                if (tried < unknown.least) tried = unknown.from_nothing > 0 ? 0 : unknown.least;
                const double before = *unknown.value;
                if (tried == before) return false;
                *unknown.value = tried;
                const double now = likely();
                if (now > best + 0.05) {
                    best = now;
                    return moved = true;
                }
                *unknown.value = before;
                return false;
            };
            if (*unknown.value == 0) {
                if (!attempt(unknown.from_nothing) && !attempt(0.3 * unknown.from_nothing)) continue;
            }
            if (unknown.from_nothing > 0 && attempt(0)) continue;
            const bool up = attempt(step * *unknown.value);
            for (int i = 0; i < 6 && attempt((up ? step : 1 / step) * *unknown.value); ++i) {
            }
        }
        if (!moved && step < 2) break;
    }
    origin_.noise = noise;  // where the next search starts
    widen(unknowns, best, likely);
    Track end;
    evidence(noise, count, models, &end);
    if (getenv("RFDEBUG")) {  // DEBUG
        const auto& b = end.belief.best();
        const auto pr = [](const RangeErrors& e) {
            fprintf(stderr, "| f %.2f c %.3f o %.3f w %.3f y %.3f s %.3f D %.0f dir %.3f g %.4f ", e.factor, e.common, e.own, e.wander, e.sway, e.stretch.scale,
                    e.stretch.depth, e.stretch.direction, e.stretch.growth);
        };
        fprintf(stderr, "learn n %zu t %.1f (%.0f) best %.1f way %.2f turn %.2f delay %.2f ", count, to_seconds(until - origin_.time), to_seconds(until), best,
                noise.way, noise.turn, noise.delay);
        pr(noise.receiver);
        pr(noise.detector);
        fprintf(stderr, "| b %.2f w %.4f c %.4f | scale %.3f+-%.3f turn %.3f+-%.3f drift %.4f+-%.4f hyp %zu\n", noise.bearing, noise.bearing_sway,
                noise.bearing_common, b.mean[state_scale], std::sqrt(b.covariance(state_scale, state_scale)), b.mean[state_turn_scale],
                std::sqrt(b.covariance(state_turn_scale, state_turn_scale)), b.mean[state_drift], std::sqrt(b.covariance(state_drift, state_drift)),
                end.belief.hypotheses.size());
    }
    end.born = origin_.born;
    learned_ = until;
    learned_once_ = true;
    wait_ = std::min(2 * wait_, longest_wait);
    noise_ = noise;
    if (count > most_events) forget(count - most_events / 2, models);
    return end;
}

/// Moves the origin on past the first `count` events.
void NoiseLearner::forget(std::size_t count, const TrackingModels& models) {
    Track later;
    evidence(noise_, count, models, &later);
    later.born = origin_.born;
    later.noise = origin_.noise;
    origin_ = later;
    events_.erase(events_.begin(), events_.begin() + static_cast<std::ptrdiff_t>(count));
}

}  // namespace roomfix
