#include "roomfix/connect/stream_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace roomfix {
namespace {

constexpr double bin = 1;               // s: of each, the least offset is kept
constexpr std::size_t kept = 60;        // bins
constexpr double drift_needs = 10;      // s of points from which a drift is told
constexpr double largest_drift = 2e-3;  // s/s: more is no clock
constexpr double jump = 2;              // s by which a clock that was set anew is off
constexpr double clocks_agree = 0.003;  // s, 1 sigma: two machines that follow NTP
constexpr double surprising = 2;        // sigmas by which the last sender report is off those before: it contradicts them ...
constexpr double settled = 1;           // ... until it is off by less
constexpr double earliest = -0.005;     // s: a picture that comes sooner than this after it was taken shows that the clocks differ
constexpr double latest = 2;            // s: and so does one that comes later
constexpr double unknown_delay = 0.05;  // s, 1 sigma: from exposure to arrival, of a camera of which nothing is known
constexpr double stated_sigma = 0.005;  // s, of a delay that the site states
constexpr double held_up = 0.05;        // s, on average: what comes later than at its soonest, where a connection is new
constexpr int by_wall_clock = 0;  // a way to tell times; by arrival is another one for each connection, as is a wall clock each time it contradicts itself
constexpr double smoothing = 0.05;

}  // namespace

void LeastOffset::add(double time, double offset) {
    if (!lowest_.empty() && std::abs(offset - at(time)) > jump) clear();
    if (lowest_.empty() || time - lowest_.back().time > bin) {
        lowest_.push_back({time, offset});
        if (lowest_.size() > kept) lowest_.pop_front();
        fit();
    } else if (offset < lowest_.back().offset) {
        lowest_.back().offset = offset;
        fit();
    }
    const double above = std::max(0.0, offset - at(time));
    jitter_ += smoothing * (above - jitter_);
}

/// The edge of the lower convex hull below the points' middle: no line below all points is closer to them in sum.
void LeastOffset::fit() {
    std::vector<Point> hull;
    double middle = 0;
    for (const Point& p : lowest_) {
        middle += p.time / static_cast<double>(lowest_.size());
        const auto turns_down = [&] {
            const Point& a = hull[hull.size() - 2];
            const Point& b = hull.back();
            return (b.offset - a.offset) * (p.time - b.time) >= (p.offset - b.offset) * (b.time - a.time);
        };
        while (hull.size() >= 2 && turns_down()) hull.pop_back();
        hull.push_back(p);
    }
    if (lowest_.back().time - lowest_.front().time < drift_needs) {
        const auto least = std::min_element(hull.begin(), hull.end(), [](const Point& a, const Point& b) { return a.offset < b.offset; });
        from_ = least->time;
        level_ = least->offset;
        slope_ = 0;
        return;
    }
    std::size_t i = 1;
    while (i + 1 < hull.size() && hull[i].time < middle) ++i;
    const Point& a = hull[i - 1];
    const Point& b = hull[i];
    slope_ = std::clamp((b.offset - a.offset) / (b.time - a.time), -largest_drift, largest_drift);
    from_ = a.time;
    level_ = a.offset;
}

double LeastOffset::at(double time) const { return level_ + slope_ * (time - from_); }

void StreamClock::restart() {
    media_.clear();
    wall_.clear();
    reports_.clear();
    contradiction_ = 0;
    wall_state_ = Wall::none;
    has_media_ = false;
    last_media_.reset();
    connection_ = ++last_way_;
    since_restart_ = 0;
    last_steady_ = last_interval_ = 0;
}

void StreamClock::follow_media(const FrameArrival& arrival) {
    has_media_ = arrival.media.has_value();
    if (has_media_) media_.add(arrival.steady, arrival.steady - *arrival.media);
}

double StreamClock::wall_sigma() const { return std::hypot(clocks_agree, reports_.spread()); }

void StreamClock::correct_wall(FrameArrival& arrival) {
    if (!arrival.wall || !arrival.media) return;
    arrival.wall = reports_.corrected(*arrival.media, *arrival.wall);
    const double sigmas = std::abs(reports_.last_off()) / wall_sigma();
    if (contradiction_ == 0 && sigmas > surprising) contradiction_ = ++last_way_;
    if (contradiction_ != 0 && sigmas <= settled) contradiction_ = 0;
}

/// A sender's wall clock is believed if pictures come after they were taken, and not much later.
void StreamClock::judge_wall(const FrameArrival& arrival) {
    if (!arrival.wall) return;
    wall_.add(arrival.steady, to_seconds(arrival.system - *arrival.wall));
    const double least = wall_.at(arrival.steady);
    wall_state_ = least < earliest ? Wall::ahead : least > latest ? Wall::behind : Wall::usable;
    if (wall_state_ == Wall::usable) learned_delay_ = std::max(0.0, least);
}

/// How unevenly pictures come of which nothing else tells the time.
void StreamClock::note_intervals(const FrameArrival& arrival) {
    if (last_steady_ > 0) {
        const double interval = arrival.steady - last_steady_;
        if (last_interval_ > 0) unevenness_ += smoothing * (std::min(0.5 * std::abs(interval - last_interval_), 0.5) - unevenness_);
        last_interval_ = interval;
    }
    last_steady_ = arrival.steady;
}

StampedTime StreamClock::by_wall(const FrameArrival& arrival) const {
    if (contradiction_ != 0) return {*arrival.wall, {std::abs(reports_.last_off()), contradiction_}};
    return {*arrival.wall, {wall_sigma(), by_wall_clock}};
}

StampedTime StreamClock::by_arrival(const FrameArrival& arrival) const {
    const double late = has_media_ ? std::max(0.0, arrival.steady - *arrival.media - media_.at(arrival.steady)) : 0;
    const double jitter = has_media_ ? 0.2 * media_.jitter() : unevenness_;
    const double delay = stated_delay_.value_or(learned_delay_.value_or(0));
    const double sigma = stated_delay_ || learned_delay_ ? stated_sigma : unknown_delay;
    // The soonest of n pictures is later than any could be, by 1/n of how late they come on average.
    const double unsettled = held_up / std::max(since_restart_, 1);
    return {arrival.system - from_seconds(late + delay), {std::hypot(sigma, jitter, unsettled), connection_}};
}

StampedTime StreamClock::stamp(FrameArrival arrival) {
    ++since_restart_;
    correct_wall(arrival);
    follow_media(arrival);
    judge_wall(arrival);
    note_intervals(arrival);
    StampedTime stamped = arrival.wall && wall_state_ == Wall::usable ? by_wall(arrival) : by_arrival(arrival);
    // Where the way to tell the time changes, times must not run back; a clock that was set back by more is followed, and pictures may be sent in
    // another order than they were taken in.
    constexpr Nanoseconds least_step = 1000;
    const bool reordered = arrival.media && last_media_ && *arrival.media < *last_media_;
    last_media_ = arrival.media;
    if (!reordered && stamped.time <= last_.time && last_.time - stamped.time < from_seconds(jump)) stamped.time = last_.time + least_step;
    last_ = stamped;
    return stamped;
}

std::string StreamClock::told() const {
    const int sigma = static_cast<int>(std::ceil(1e3 * last_.error.sigma));
    switch (wall_state_) {
        case Wall::usable:
            return fmt::format("times are the camera's own, +-{} ms if its clock follows NTP; pictures take {:.0f} ms to come", sigma,
                               1e3 * (learned_delay_.value_or(0) + wall_.jitter()));
        case Wall::ahead:
        case Wall::behind:
            return fmt::format("times are those of arrival, +-{} ms: the camera's clock is {:.3g} s {} ours; let both follow NTP", sigma,
                               std::abs(wall_.at(last_steady_)), wall_state_ == Wall::ahead ? "ahead of" : "behind");
        case Wall::none:
            break;
    }
    const std::string delay = stated_delay_    ? fmt::format("less the stated delay of {:.0f} ms", 1e3 * *stated_delay_)
                              : learned_delay_ ? fmt::format("less {:.0f} ms, as they took before", 1e3 * *learned_delay_)
                                               : std::string("and it is not known how long they take to come; state it as 'delay'");
    return fmt::format("times are those of arrival, +-{} ms, {}", sigma, delay);
}

}  // namespace roomfix
