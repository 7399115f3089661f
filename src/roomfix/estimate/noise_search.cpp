#include "roomfix/estimate/noise_search.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr double usual_wheels = 2;      // times the random errors of good wheels
constexpr double spread_of_wheels = 1;  // of its logarithm
constexpr double way_like_turn = 0.7;   // by so much the logarithms of their errors of way and turning differ
constexpr double usual_delay = 0.3;     // s, between what wheels say and what the robot does
constexpr double usual_ways = 0.7;      // spread of the logarithm of the way over which errors change with the place
constexpr double shift = 0.1;           // s, of the delay in the first steps
constexpr double cost_of_an_error = 3;  // nats: a kind of error that explains less is left out

/// One number of the noise that is sought.
struct Unknown {
    double* value;
    double from_nothing = 0;  // what to try where it is 0; 0: it is never 0
    double usual = 1;         // its logarithm is normally distributed around that of this ...
    double spread = 1.5;      // ... with this standard deviation
    double least = 0.05, most = 50;
    bool known = false;            // there is such an error, as far as anything is known beforehand
    RangeErrors* among = nullptr;  // what stays: what of these changes with the place may have been taken for it

    double log_prior() const {
        if (from_nothing > 0 && *value == 0) return known ? -cost_of_an_error : 0;
        const double z = std::log(*value / usual) / spread;
        return -0.5 * z * z - (from_nothing > 0 && !known ? cost_of_an_error : 0);
    }
};

/// `sways`: nobody measures so well that nothing changes with the place; what all ranges have in common does so (a detector), or those to each beacon.
void add_ranges(RangeErrors& errors, double sigma, bool sways, std::vector<Unknown>& unknowns) {
    const double now = errors.factor * sigma;
    const double least = 0.05 * sigma, most = 1000 * sigma;
    unknowns.push_back({.value = &errors.factor, .most = 1000});
    unknowns.push_back({&errors.wander, now, sigma, 1, least, most, !sways});
    unknowns.push_back({&errors.sway, now, sigma, 1, least, most, sways});
    unknowns.push_back({&errors.own, now, sigma, 1, least, most, false, &errors});
    unknowns.push_back({&errors.common, 2 * now, sigma, 1, least, most, false, &errors});
    unknowns.push_back({&errors.stretch.scale, 0.03, 0.02, 0.7, 0.002, 0.3});
    unknowns.push_back({&errors.stretch.direction, 0.05, 0.05, 0.7, 0.005, 0.5});
    unknowns.push_back({&errors.stretch.curve, 0.005, 0.004, 0.7, 0.0004, 0.05});
    unknowns.push_back({&errors.stretch.growth, 0.01, 0.01, 0.7, 0.001, 0.2});
}

std::vector<Unknown> unknowns_of(SenseNoise& noise, const SensedKinds& kinds) {
    std::vector<Unknown> unknowns;
    if (kinds.wheels) {
        unknowns.push_back({&noise.way, 0, usual_wheels, spread_of_wheels});
        unknowns.push_back({&noise.turn, 0, usual_wheels, spread_of_wheels});
    } else {
        unknowns.push_back({.value = &noise.push});
        unknowns.push_back({.value = &noise.twist});
    }
    if (kinds.ranges) add_ranges(noise.receiver, kinds.range_sigma, false, unknowns);
    if (kinds.sighted_ranges) add_ranges(noise.detector, kinds.sighted_sigma, true, unknowns);
    if (kinds.bearings) {
        unknowns.push_back({&noise.bearing});
        unknowns.push_back({&noise.bearing_sway, kinds.bearing_sigma, kinds.bearing_sigma, 1, 0.1 * kinds.bearing_sigma, 0.5, true});
        unknowns.push_back({&noise.bearing_shape, 0.03, 0.03, 0.7, 0.003, 0.3});
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

}  // namespace

NoiseSearch::NoiseSearch(const SensedKinds& kinds, const std::optional<SenseNoise>& before, const Evidence& evidence)
    : kinds_(kinds), before_(before), evidence_(evidence) {}

/// The numbers of `noise`, with what is known of each beforehand.
static std::vector<Unknown> unknowns_in(SenseNoise& noise, const SensedKinds& kinds, const std::optional<SenseNoise>& before) {
    std::vector<Unknown> unknowns = unknowns_of(noise, kinds);
    if (!before) return unknowns;
    SenseNoise known = *before;
    expect(unknowns, unknowns_of(known, kinds));
    return unknowns;
}

double NoiseSearch::log_density(const SenseNoise& noise) const {
    SenseNoise tried = noise;
    double sum = evidence_(noise);
    for (const Unknown& u : unknowns_in(tried, kinds_, before_)) sum += u.log_prior();
    for (const RangeErrors* errors : {&noise.receiver, &noise.detector}) {
        sum -= errors->stretch.depth > 0 ? cost_of_an_error : 0;
        sum -= errors->way == 1 ? 0 : cost_of_an_error + 0.5 * std::pow(std::log(errors->way) / usual_ways, 2);
    }
    const double delay = before_ ? before_->delay : 0;
    return sum - 0.5 * std::pow(std::log(noise.way / noise.turn) / way_like_turn, 2) - 0.5 * std::pow((noise.delay - delay) / usual_delay, 2);
}

NoiseSearch::Result NoiseSearch::best(const SenseNoise& start) const {
    constexpr double clearly = 0.05;  // nats: less is no gain
    constexpr int most_steps = 6;
    Result result{start, log_density(start)};
    SenseNoise& noise = result.noise;
    std::vector<Unknown> unknowns = unknowns_of(noise, kinds_);
    const auto attempt = [&](const auto& change) {
        const SenseNoise before = noise;
        change();
        const double now = log_density(noise);
        if (now > result.log_density + clearly) {
            result.log_density = now;
            return true;
        }
        noise = before;
        return false;
    };
    // One way or, if that is no better, the other, and on as long as it helps.
    const auto go_on = [&](const auto& ahead, const auto& back) {
        const bool helped = ahead();
        bool moved = helped;
        for (int i = 0; i < most_steps && (helped ? ahead() : back()); ++i) moved = true;
        return moved;
    };
    const auto try_delays = [&](double by) {
        const auto to = [&](double tried) { return attempt([&] { noise.delay = tried; }); };
        return go_on([&] { return to(noise.delay + by); }, [&] { return to(noise.delay - by); });
    };
    const auto try_depths = [&](RangeErrors& errors) { return attempt([&] { errors.stretch.depth = 1 - errors.stretch.depth; }); };
    // What changes with the place: over another way, but over a short one by as much as before.
    const auto change_way = [&](RangeErrors& errors, double times) {
        const double amount = std::sqrt(times);
        errors.way *= times;
        errors.wander *= amount;
        errors.sway *= amount;
        if (&errors == &noise.detector) noise.bearing_sway *= amount;
    };
    const auto try_ways = [&](RangeErrors& errors, double step) {
        const auto by = [&](double times) { return attempt([&] { change_way(errors, times); }); };
        return go_on([&] { return by(step); }, [&] { return by(1 / step); });
    };
    // What stays was taken for what changes with the place as long as there was nothing else: with less of that, or over a shorter way.
    const auto instead_of_changes = [&](const Unknown& unknown) {
        constexpr double less = 0.6, shorter = 0.4;
        RangeErrors& errors = *unknown.among;
        const auto with = [&](const auto& change) {
            return attempt([&] {
                *unknown.value = unknown.from_nothing;
                change();
            });
        };
        return with([&] { (errors.sway > 0 ? errors.sway : errors.wander) *= less; }) || with([&] { change_way(errors, shorter); });
    };
    const auto try_values = [&](const Unknown& unknown, double step) {
        double& value = *unknown.value;
        const auto to = [&](double tried) {
            if (tried > unknown.most) return false;
            if (tried < unknown.least) tried = unknown.from_nothing > 0 ? 0 : unknown.least;
            return tried != value && attempt([&] { value = tried; });
        };
        bool moved = false;
        if (value == 0) {
            moved = to(unknown.from_nothing) || to(0.3 * unknown.from_nothing) || (unknown.among != nullptr && instead_of_changes(unknown));
            if (!moved) return false;
        }
        if (unknown.from_nothing > 0 && to(0)) return true;
        const bool stepped = go_on([&] { return to(step * value); }, [&] { return to(1 / step * value); });
        return moved || stepped;
    };
    for (const double step : {2.0, 2.0, 1.4, 1.2}) {
        bool moved = false;
        if (kinds_.ranges) moved |= try_depths(noise.receiver);
        if (kinds_.sighted_ranges) moved |= try_depths(noise.detector);
        if (kinds_.wheels) moved |= try_delays(shift * (step - 1));
        if (kinds_.ranges) moved |= try_ways(noise.receiver, step);
        if (kinds_.sighted_ranges || kinds_.bearings) moved |= try_ways(noise.detector, step);
        for (const Unknown& unknown : unknowns) moved |= try_values(unknown, step);
        if (!moved && step < 2) break;
    }
    return result;
}

SenseNoise NoiseSearch::widened(const Result& best) const {
    constexpr double step = 1.5;
    constexpr double widest = 1;  // of the logarithm's standard deviation
    SenseNoise noise = best.noise;
    std::vector<Unknown> unknowns = unknowns_of(noise, kinds_);
    std::vector<double> wider;
    for (const Unknown& unknown : unknowns) {
        const double value = *unknown.value;
        wider.push_back(value);
        if (value == 0) continue;
        const auto density_at = [&](double tried) {
            *unknown.value = tried;
            const double density = log_density(noise);
            *unknown.value = value;
            return density;
        };
        const double curvature = (2 * best.log_density - density_at(step * value) - density_at(value / step)) / std::pow(std::log(step), 2);
        const double variance = curvature > 0 ? std::min(1 / curvature, widest * widest) : widest * widest;
        wider.back() = value * std::exp(variance);
    }
    for (std::size_t i = 0; i < unknowns.size(); ++i) *unknowns[i].value = wider[i];
    return noise;
}

}  // namespace roomfix
