#include "roomfix/pipeline/input_doctor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include "roomfix/base/median.hpp"
#include "roomfix/ranging/trilateration.hpp"

namespace roomfix {
namespace {

constexpr double examined = 60;        // s of a recording that are examined at a time
constexpr double clearly = 20;         // nats: a mistake is told if the senses are that much likelier without it ...
constexpr double clearly_each = 0.05;  // ... and so much for each observation
constexpr double enough = 250;         // readings of a stretch that are examined
constexpr std::size_t most_pairs = 28;
constexpr double foot = 0.3048;  // m
constexpr double farthest = 20;  // m, that a range may be if nothing is known

/// Density of a reading that is compared with nothing: anywhere in a hall, in any direction.
double log_density_of_nothing(const RangeObservation&) { return -std::log(farthest); }
double log_density_of_nothing(const RangeDifferenceObservation&) { return -std::log(farthest); }
double log_density_of_nothing(const SightingObservation& o) { return (o.range ? -std::log(farthest) : 0) - (o.bearing ? std::log(2 * std::numbers::pi) : 0); }

/// Ranges, and where the robot was when it heard them.
struct HeardOnTheWay {
    std::vector<std::pair<RangeObservation, Pose2>> heard;
};

/// A run of the tracker over what one robot sensed.
struct Examination {
    double log_density = 0;
    HeardOnTheWay way;
};

template <class T>
void keep_between(std::vector<T>& all, Nanoseconds from, Nanoseconds to) {
    std::erase_if(all, [&](const T& o) { return o.time < from || o.time > to; });
}

/// Leaves about a part of them, spread so that no order in which beacons take turns plays along.
template <class T>
void thin_out(std::vector<T>& all, double part) {
    std::size_t i = 0;
    std::erase_if(all, [&](const T&) { return std::fmod(static_cast<double>(++i) / std::numbers::phi, 1) >= part; });
}

Senses between(Senses senses, Nanoseconds from, Nanoseconds to) {
    keep_between(senses.ranges, from, to);
    keep_between(senses.differences, from, to);
    keep_between(senses.sightings, from, to);
    keep_between(senses.odometry, from, to);
    const double part = enough / static_cast<double>(senses.ranges.size() + senses.differences.size() + senses.sightings.size() + 1);
    if (part >= 1) return senses;
    thin_out(senses.ranges, part);
    thin_out(senses.differences, part);
    thin_out(senses.sightings, part);
    return senses;
}

template <class T>
void widen(const std::vector<T>& all, Nanoseconds& first, Nanoseconds& last) {
    if (all.empty()) return;
    first = std::min(first, all.front().time);
    last = std::max(last, all.back().time);
}

/// One after the other in the order of their times; `visit` gets each.
template <class Visit>
void in_order(const Senses& senses, Visit& visit) {
    constexpr Nanoseconds ended = std::numeric_limits<Nanoseconds>::max();
    std::size_t odometry = 0, range = 0, difference = 0, sighting = 0;
    const auto time_of = [&](const auto& all, std::size_t i) { return i < all.size() ? all[i].time : ended; };
    while (true) {
        const Nanoseconds times[] = {time_of(senses.odometry, odometry), time_of(senses.ranges, range), time_of(senses.differences, difference),
                                     time_of(senses.sightings, sighting)};
        const Nanoseconds next = *std::min_element(std::begin(times), std::end(times));
        if (next == ended) return;
        if (times[0] == next) {
            visit(senses.odometry[odometry++]);
        } else if (times[1] == next) {
            visit(senses.ranges[range++]);
        } else if (times[2] == next) {
            visit(senses.differences[difference++]);
        } else {
            visit(senses.sightings[sighting++]);
        }
    }
}

/// Gives a tracker what a robot sensed, and keeps what it made of it.
struct TrackerFeed {
    Tracker& tracker;
    int robot;
    Examination& result;
    double untold = 0;  // log density of all readings if nothing is known
    long readings = 0;

    void operator()(const OdometryObservation& o) {
        tracker.go_on(o.time);
        tracker.observe(o);
    }
    void operator()(const RangeObservation& o) {
        count(o);
        tracker.observe(o);
        const Track* track = tracker.track(robot);
        if (track != nullptr && track->belief.best_weight() > 0.9) result.way.heard.push_back({o, track->belief.best().pose()});
    }
    void operator()(const RangeDifferenceObservation& o) {
        count(o);
        tracker.observe(o);
    }
    void operator()(const SightingObservation& o) {
        count(o);
        tracker.observe(o);
    }

private:
    template <class Observation>
    void count(const Observation& o) {
        tracker.go_on(o.time);
        untold += log_density_of_nothing(o);
        ++readings;
    }
};

Examination examine(const Site& site, int robot, const Senses& senses) {
    TrackerSettings settings;
    settings.learns = false;
    Tracker tracker(site, settings);
    Examination result;
    TrackerFeed feed{tracker, robot, result};
    in_order(senses, feed);
    const Track* track = tracker.track(robot);
    if (track == nullptr || feed.readings == 0) {
        result.log_density = feed.untold;
        return result;
    }
    // What came before it was found counts as if nothing had been known.
    const double each = feed.untold / static_cast<double>(feed.readings);
    result.log_density = track->evidence + each * static_cast<double>(feed.readings - track->weighed);
    return result;
}

/// A likely mistake, undone: how the inputs change, and what to say if they fit better then.
struct Remedy {
    std::string told;
    std::function<void(Senses&, Site&)> apply;
    double nats = 0;  // to be added, where readings change their unit or are left out
};

void scale_ranges(Senses& senses, double factor) {
    for (RangeObservation& o : senses.ranges) o.range *= factor;
    for (RangeDifferenceObservation& o : senses.differences) o.difference *= factor;
    for (SightingObservation& o : senses.sightings) {
        if (o.range) *o.range *= factor;
    }
}

std::size_t ranges_in(const Senses& senses) {
    const auto sighted = std::count_if(senses.sightings.begin(), senses.sightings.end(), [](const SightingObservation& o) { return o.range.has_value(); });
    return senses.ranges.size() + senses.differences.size() + static_cast<std::size_t>(sighted);
}

std::vector<int> beacons_heard(const Senses& senses, const Site& site) {
    std::vector<int> heard;
    for (int beacon = 0; beacon < static_cast<int>(site.beacons.size()); ++beacon) {
        const bool used = std::any_of(senses.ranges.begin(), senses.ranges.end(), [&](const RangeObservation& o) { return o.beacon == beacon; });
        if (used) heard.push_back(beacon);
    }
    return heard;
}

/// Where a beacon stands by the ranges to it from a robot whose way is known; nothing where they do not agree on a place.
std::optional<Eigen::Vector2d> place_of_beacon(int beacon, const HeardOnTheWay& way, const SiteRobot& robot, double height) {
    constexpr std::size_t most = 60;
    std::vector<BeaconRange> ranges;
    for (const auto& [range, pose] : way.heard) {
        if (range.beacon != beacon) continue;
        const Eigen::Vector3d own = robot.receivers.empty()
                                        ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                        : robot.receivers[std::min(static_cast<std::size_t>(range.receiver), robot.receivers.size() - 1)].position;
        ranges.push_back({map_from_robot(pose) * own, range.range, std::max(range.sigma, 0.1)});
    }
    if (ranges.size() < 8) return std::nullopt;
    std::vector<BeaconRange> some;
    for (std::size_t i = 0; i < std::min(most, ranges.size()); ++i) some.push_back(ranges[i * ranges.size() / std::min(most, ranges.size())]);
    const auto found = trilaterate(some, {}, height);
    if (!found) return std::nullopt;
    const double agree = static_cast<double>(std::count_if(found->on_time.begin(), found->on_time.end(), [](double p) { return p > 0.5; }));
    if (agree < 0.5 * static_cast<double>(some.size()) || found->places[0].weight < 0.9) return std::nullopt;
    return found->places[0].position;
}

/// Mistakes of units and sides that a recording may hold.
std::vector<Remedy> remedies_of_units(const Senses& senses, const std::string& id) {
    std::vector<Remedy> all;
    const auto number = static_cast<double>(ranges_in(senses));
    const auto unit = [&](const char* name, double factor) {
        if (number == 0) return;
        all.push_back({fmt::format("robot {}: its ranges seem to be in {}: write them in metres", id, name),
                       [factor](Senses& s, Site&) { scale_ranges(s, factor); }, number * std::log(factor)});
    };
    unit("feet", foot);
    unit("centimetres", 0.01);
    unit("millimetres", 0.001);
    if (!senses.odometry.empty()) {
        all.push_back(
            {fmt::format("robot {}: its odometry turns the wrong way: left and right seem to be exchanged (yaw is positive to the left, y is to the left); "
                         "exchange the wheels' wires or the signs of y and yaw",
                         id),
             [](Senses& s, Site&) {
                 for (OdometryObservation& o : s.odometry) {
                     o.pose.y = -o.pose.y;
                     o.pose.yaw = -o.pose.yaw;
                 }
             }});
    }
    const auto bearings = std::count_if(senses.sightings.begin(), senses.sightings.end(), [](const SightingObservation& o) { return o.bearing.has_value(); });
    if (bearings > 0) {
        all.push_back({fmt::format("robot {}: its bearings count the wrong way: positive is to the left of straight ahead", id), [](Senses& s, Site&) {
                           for (SightingObservation& o : s.sightings) {
                               if (o.bearing) o.bearing = -*o.bearing;
                           }
                       }});
        all.push_back({fmt::format("robot {}: its bearings seem to be in degrees: write them in radians", id),
                       [](Senses& s, Site&) {
                           for (SightingObservation& o : s.sightings) {
                               if (o.bearing) o.bearing = wrap_angle(radians(*o.bearing));
                           }
                       },
                       static_cast<double>(bearings) * std::log(radians(1))});
    }
    return all;
}

void exchange_beacons(Senses& senses, int a, int b) {
    const auto other = [&](int beacon) { return beacon == a ? b : beacon == b ? a : beacon; };
    for (RangeObservation& o : senses.ranges) o.beacon = other(o.beacon);
    for (RangeDifferenceObservation& o : senses.differences) o.beacons = {other(o.beacons[0]), other(o.beacons[1])};
}

/// Pairs that may be exchanged: all of few, of many those that the robot's way puts in each other's place.
std::vector<std::pair<int, int>> pairs_of(const std::vector<int>& beacons, const Site& site, const SiteRobot& robot, const HeardOnTheWay& way) {
    std::vector<std::pair<int, int>> pairs;
    for (std::size_t i = 0; i < beacons.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) pairs.emplace_back(beacons[k], beacons[i]);
    }
    if (pairs.size() <= most_pairs) return pairs;
    const auto swapped = [&](int a, int b) {
        const Eigen::Vector3d& pa = site.beacons[static_cast<std::size_t>(a)].position;
        const Eigen::Vector3d& pb = site.beacons[static_cast<std::size_t>(b)].position;
        const auto seen = place_of_beacon(a, way, robot, pa.z());
        return seen && (*seen - pb.head<2>()).norm() < 0.3 * (pa - pb).norm();
    };
    std::erase_if(pairs, [&](const auto& pair) { return !swapped(pair.first, pair.second) || !swapped(pair.second, pair.first); });
    if (pairs.size() > most_pairs) pairs.resize(most_pairs);
    return pairs;
}

struct Verdict {
    double gain = 0;  // nats
    std::string told;
};

/// A beacon that the robot's way by all others contradicts: where these put it.
std::string about_beacon(const SiteBeacon& known, int beacon, const Senses& senses, const HeardOnTheWay& others, const SiteRobot& robot) {
    constexpr double lately = 0.3;  // s
    HeardOnTheWay way;
    for (const RangeObservation& o : senses.ranges) {
        if (o.beacon != beacon) continue;
        const auto age = [&](const auto& heard) { return std::abs(to_seconds(heard.first.time - o.time)); };
        const auto near = std::min_element(others.heard.begin(), others.heard.end(), [&](const auto& a, const auto& b) { return age(a) < age(b); });
        if (near != others.heard.end() && age(*near) < lately) way.heard.push_back({o, near->second});
    }
    const auto place = place_of_beacon(beacon, way, robot, known.position.z());
    if (!place) return fmt::format("beacon {} is not where the site says, or was moved: measure its position again", known.id);
    return fmt::format("beacon {} seems to be at ({:.2f}, {:.2f}), {:.2f} m from where the site says: measure its position again", known.id, place->x(),
                       place->y(), (*place - known.position.head<2>()).norm());
}

/// The likeliest mistake in a stretch of a recording, if there is one.
std::optional<Verdict> verdict_on(const Site& site, int robot, const Senses& senses) {
    const SiteRobot& own = site.robots[static_cast<std::size_t>(robot)];
    const Examination as_it_is = examine(site, robot, senses);
    const auto readings = static_cast<double>(senses.ranges.size() + senses.differences.size() + senses.sightings.size());
    Verdict best{std::max(clearly, clearly_each * readings), ""};
    const auto attempt = [&](const Remedy& remedy) {
        Senses changed = senses;
        Site other = site;
        remedy.apply(changed, other);
        if (changed.empty()) return;
        const Examination then = examine(other, robot, changed);
        const double gain = then.log_density + remedy.nats - as_it_is.log_density;
        if (gain <= best.gain) return;
        best = {gain, remedy.told};
    };
    for (const Remedy& remedy : remedies_of_units(senses, own.id)) attempt(remedy);
    // What explains everything needs no rival.
    constexpr double all_of_it = 0.5;  // nats for each observation
    if (!best.told.empty() && best.gain > all_of_it * readings) return best;
    const std::vector<int> beacons = beacons_heard(senses, site);
    for (const auto& [a, b] : pairs_of(beacons, site, own, as_it_is.way)) {
        const std::string& first = site.beacons[static_cast<std::size_t>(a)].id;
        const std::string& second = site.beacons[static_cast<std::size_t>(b)].id;
        attempt({fmt::format("beacons {} and {} seem to be exchanged: exchange their positions in the site file, or the beacons", first, second),
                 [a = a, b = b](Senses& s, Site&) { exchange_beacons(s, a, b); }});
    }
    for (const int beacon : beacons) {
        if (beacons.size() < 3) break;
        Senses others = senses;
        std::erase_if(others.ranges, [&](const RangeObservation& o) { return o.beacon == beacon; });
        const Examination without = examine(site, robot, others);
        const double left_out = -std::log(farthest) * static_cast<double>(senses.ranges.size() - others.ranges.size());
        const double gain = without.log_density + left_out - as_it_is.log_density;
        if (gain > best.gain) best = {gain, about_beacon(site.beacons[static_cast<std::size_t>(beacon)], beacon, senses, without.way, own)};
    }
    if (best.told.empty()) return std::nullopt;
    return best;
}

/// Is what was learned of the robot's senses what senses are like?
bool unusual(const Track& track, const TrackingModels& models) {
    constexpr double wheels = 6;          // times good wheels' noise
    constexpr double range_error = 0.15;  // m
    constexpr double factor = 8;
    const auto strange = [&](const RangeErrors& e, double sigma) {
        const double scatter = e.factor * sigma;
        return std::max({e.common, e.own, e.wander, e.sway, scatter}) > range_error || (e.factor > factor && scatter > 0.3 * range_error);
    };
    const SiteRobot& robot = models.site.robots[static_cast<std::size_t>(track.robot)];
    const double sigma = robot.receiver() ? robot.receiver()->sigma : Receiver{}.sigma;
    return track.noise.way > wheels || track.noise.turn > wheels || strange(track.noise.receiver, sigma) ||
           strange(track.noise.detector, robot.detector.value_or(Detector{}).range_sigma) || track.noise.bearing > factor || track.agreement < 0.7;
}

/// How well do way and yaw go together, for a robot that drives where it looks? 1: it always does, 0: at random.
double coherence(const std::vector<OdometryObservation>& odometry, double yaw_unit) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double ways = 0;
    for (std::size_t i = 0; i + 1 < odometry.size();) {
        // Steps long enough to have a direction.
        std::size_t k = i + 1;
        const auto way = [&] { return Eigen::Vector2d(odometry[k].pose.x - odometry[i].pose.x, odometry[k].pose.y - odometry[i].pose.y); };
        while (k + 1 < odometry.size() && way().norm() < 1e-2) ++k;
        const double length = way().norm();
        const double middle = 0.5 * (odometry[i].pose.yaw + odometry[k].pose.yaw) * yaw_unit;
        const double turned = std::abs(odometry[k].pose.yaw - odometry[i].pose.yaw) * yaw_unit;
        // Forward and backward are alike; pieces in which the yaw jumps over its seam say nothing.
        if (length > 0 && turned < 1) {
            const double off = 2 * (std::atan2(way().y(), way().x()) - middle);
            sum += length * Eigen::Vector2d(std::cos(off), std::sin(off));
            ways += length;
        }
        i = k;
    }
    return ways > 0 ? sum.norm() / ways : 0;
}

/// What was learned of the wheels, where it is more than wheels do.
std::vector<std::string> about_wheels(const Track& track, const std::string& id, const std::function<double(double)>& gain_by_delay) {
    constexpr double bad_wheels = 15;  // times good wheels' noise
    constexpr double apart = 0.1;      // s
    std::vector<std::string> told;
    const double worse = std::max(track.noise.way, track.noise.turn);
    if (worse > bad_wheels) {
        told.push_back(fmt::format(
            "robot {}: its odometry errs {:.0f} times as much as good wheels do: check its units (m, rad), its clock and that it is this robot's", id, worse));
    }
    const double delay = track.noise.delay;
    if (std::abs(delay) > apart && gain_by_delay(delay) > clearly) {
        told.push_back(fmt::format(
            "robot {}: it moves {:.2f} s {} than its odometry says: the clocks of its odometry and of what it hears or sees differ; the fixes allow "
            "for it, but mend the clocks",
            id, std::abs(delay), delay > 0 ? "later" : "sooner"));
    }
    return told;
}

}  // namespace

std::string wrong_units(const std::vector<OdometryObservation>& odometry, const SiteRobot& robot) {
    constexpr double too_fast = 20;    // m/s
    constexpr std::size_t least = 20;  // poses
    constexpr double turned_far = 7;   // rad: a robot that never turned by more says nothing about degrees
    constexpr double well = 0.95, badly = 0.7;
    if (odometry.size() < least) return "";
    std::vector<double> speeds;
    double low = odometry[0].pose.yaw, high = low;
    for (std::size_t i = 1; i < odometry.size(); ++i) {
        const double seconds = to_seconds(odometry[i].time - odometry[i - 1].time);
        const double way = std::hypot(odometry[i].pose.x - odometry[i - 1].pose.x, odometry[i].pose.y - odometry[i - 1].pose.y);
        if (seconds > 0 && seconds < 2 && way > 0) speeds.push_back(way / seconds);
        low = std::min(low, odometry[i].pose.yaw);
        high = std::max(high, odometry[i].pose.yaw);
    }
    if (speeds.size() >= least) {
        const double usual = median(speeds);
        if (usual > too_fast) {
            return fmt::format("robot {}: its odometry drives at {:.0f} m/s: x and y seem to be in millimetres; write metres", robot.id, usual);
        }
    }
    if (high - low < turned_far) return "";
    const double as_radians = coherence(odometry, 1);
    const double as_degrees = coherence(odometry, radians(1));
    if (as_degrees < well || as_radians > badly) return "";
    return fmt::format("robot {}: its odometry's yaw goes from {:.0f} to {:.0f} and points along the way only if it is in degrees; write radians", robot.id,
                       low, high);
}

std::vector<std::string> suspicions(const Tracker& tracker, int robot, const Senses& senses) {
    if (senses.empty()) return {};
    const Track* track = tracker.track(robot);
    if (track != nullptr && track->searched == never) return {};
    const Site& site = tracker.models().site;
    Nanoseconds first = std::numeric_limits<Nanoseconds>::max(), last = std::numeric_limits<Nanoseconds>::min();
    widen(senses.ranges, first, last);
    widen(senses.differences, first, last);
    widen(senses.sightings, first, last);
    const Nanoseconds length = from_seconds(examined);
    std::vector<std::string> told;
    if (track != nullptr) {
        told = about_wheels(*track, site.robots[static_cast<std::size_t>(robot)].id, [&](double delay) {
            Senses stretch = between(senses, first, first + length);
            const double before = examine(site, robot, stretch).log_density;
            for (OdometryObservation& o : stretch.odometry) o.time += from_seconds(delay);
            return examine(site, robot, stretch).log_density - before;
        });
        if (!unusual(*track, tracker.models())) return told;
    }
    for (const Nanoseconds from : {first, std::max(first, last - length)}) {
        const Senses stretch = between(senses, from, from + length);
        if (const auto verdict = verdict_on(site, robot, stretch)) {
            told.push_back(verdict->told);
            break;
        }
        if (last - first <= length) break;
    }
    return told;
}

}  // namespace roomfix
