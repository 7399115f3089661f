#include "roomfix/estimate/open_names.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr std::size_t most_namings = 128;  // ways to give all names at once that are compared
constexpr double ask_again = 1;            // s until a track that got no name may get one

/// All but those that are seen where they should be.
std::vector<FreeRobot> free_robots(const Association& association, Nanoseconds time, const Group& group, const TrackingModels& models) {
    std::vector<FreeRobot> free;
    for (const int robot : group.robots) {
        const auto known = std::find_if(association.tracks.begin(), association.tracks.end(), [&](const Track& t) { return t.is(robot); });
        const bool lost =
            known == association.tracks.end() || known->belief.best().place_sigma() > models.site.lost || known->hardly_known(time, models.settings.ok);
        if (lost) {
            free.push_back({robot});
        } else if (to_seconds(time - known->seen) >= models.settings.ok) {
            free.push_back({robot, probability_elsewhere(*known, models.settings), known->seen});
        }
    }
    return free;
}

/// How many of them are to be expected elsewhere: at least one, where a track is one of them.
double expected_elsewhere(const std::vector<FreeRobot>& free) {
    double sum = 0;
    for (const FreeRobot& f : free) sum += f.elsewhere;
    return std::max(sum, 1.0);
}

/// A robot whose name a new track may get. It stands for all those that nothing will ever tell apart: the likeliest of them is taken.
struct FreeName {
    FreeRobot first;
    double elsewhere = 1;  // of all that it stands for: so many are to be expected elsewhere

    /// Probability that it is this one of them.
    double by_chance() const { return first.elsewhere / elsewhere; }
};

std::vector<FreeName> free_names(const std::vector<FreeRobot>& free, const Group& group, const TrackingModels& models) {
    std::vector<FreeName> names;
    for (const FreeRobot& one : free) {
        const auto alike = std::find_if(names.begin(), names.end(), [&](const FreeName& n) {
            return !models.has_mark(one.robot) && !models.has_mark(n.first.robot) && group.kind_of(n.first.robot) == group.kind_of(one.robot);
        });
        if (alike == names.end()) {
            names.push_back({one, one.elsewhere});
            continue;
        }
        if (one.elsewhere > alike->first.elsewhere) alike->first = one;
        alike->elsewhere += one.elsewhere;
    }
    return names;
}

/// Nats for a track's being a robot with such a name.
double name_nats(const Track& track, const FreeName& name, const std::vector<FreeRobot>& free, const Group& group, const TrackingModels& models) {
    const int robot = name.first.robot;
    return std::log(prior_of(name.elsewhere, free)) + looks_like(track, robot, group) + way_of(robot, track, models);
}

/// A robot that is not missing is where it is thought to be, until its wheels have turned and say that it is likelier this track: what stands still is like
/// every robot that does.
bool may_be(const Track& track, const FreeName& name, const std::vector<FreeRobot>& free, const Group& group, const TrackingModels& models) {
    constexpr double least_way = 0.3;  // m
    if (name.first.is_missing()) return true;
    const auto own = std::find_if(track.names.begin(), track.names.end(), is_of(name.first.robot));
    if (own == track.names.end() || own->way < least_way) return false;
    return name_nats(track, name, free, group, models) > std::log(no_robot) + way_of_stranger(track);
}

/// The likeliest ways to name tracks.
std::vector<Naming> likely_namings(const Association& association, const std::vector<std::size_t>& tracks, const std::vector<FreeRobot>& free,
                                   const Group& group, const TrackingModels& models) {
    std::vector<Naming> namings = {{{}, {}, {}, free, 0}};
    for (const std::size_t t : tracks) {
        const Track& track = association.tracks[t];
        std::vector<Naming> longer;
        for (const Naming& naming : namings) {
            longer.push_back(naming);
            longer.back().robots.push_back(-1);
            longer.back().by_chance.push_back(1);
            longer.back().elsewhere.push_back(0);
            longer.back().log_weight += std::log(no_robot) + way_of_stranger(track);
            for (const FreeName& name : free_names(naming.free, group, models)) {
                if (!may_be(track, name, naming.free, group, models)) continue;
                Naming& next = longer.emplace_back(naming);
                next.robots.push_back(name.first.robot);
                next.by_chance.push_back(name.by_chance());
                next.elsewhere.push_back(name.elsewhere);
                next.log_weight += name_nats(track, name, naming.free, group, models);
                std::erase_if(next.free, with_robot(name.first.robot));
            }
        }
        std::stable_sort(longer.begin(), longer.end(), [](const Naming& a, const Naming& b) { return a.log_weight > b.log_weight; });
        if (longer.size() > most_namings) longer.resize(most_namings);
        namings = std::move(longer);
    }
    return namings;
}

}  // namespace

double prior_of(double elsewhere, const std::vector<FreeRobot>& free) { return (1 - no_robot) * elsewhere / expected_elsewhere(free); }

bool all_followed(const Association& association, Nanoseconds time, const Group& group, const TrackingModels& models) {
    const auto free = free_robots(association, time, group, models);
    return std::none_of(free.begin(), free.end(), [](const FreeRobot& f) { return f.is_missing(); });
}

double way_of_stranger(const Track& track) {
    const auto stranger = std::find_if(track.names.begin(), track.names.end(), [](const PossibleName& name) { return name.is_stranger(); });
    return stranger == track.names.end() ? 0 : std::log(0.5 * (1 + std::exp(stranger->evidence)));
}

double way_of(int robot, const Track& track, const TrackingModels& models) {
    const auto own = std::find_if(track.names.begin(), track.names.end(), is_of(robot));
    const double told = own == track.names.end() ? 0 : own->evidence;
    return models.driven[static_cast<std::size_t>(robot)].empty() ? told + way_of_stranger(track) : told;
}

void propose_stranger(Track& track) {
    constexpr double even = 0.2;  // of the accelerations that robots are taken to have
    PossibleName stranger{track, 0, track.time};
    stranger.track.names.clear();
    stranger.track.noise.push = stranger.track.noise.twist = even;
    track.names.push_back(std::move(stranger));
}

void propose_name(Track& track, int robot, const TrackingModels& models) {
    if (std::any_of(track.names.begin(), track.names.end(), is_of(robot)) || !models.has_mark(robot)) return;
    const bool driven = !models.driven[static_cast<std::size_t>(robot)].empty();
    PossibleName name{track, driven ? way_of_stranger(track) : 0, track.time};
    name.track.names.clear();
    name.track.robot = robot;
    name.track.named = true;
    track.names.push_back(std::move(name));
}

OpenNames open_names(Association& association, Nanoseconds time, const Group& group, const TrackingModels& models) {
    OpenNames open;
    const auto asks = [&](const Track& track) { return !track.named && track.sightings >= models.settings.confirmations; };
    if (std::none_of(association.tracks.begin(), association.tracks.end(), asks)) return open;
    open.free = free_robots(association, time, group, models);
    const std::vector<FreeName> names = free_names(open.free, group, models);
    for (std::size_t t = 0; t < association.tracks.size(); ++t) {
        Track& track = association.tracks[t];
        if (!asks(track)) continue;
        if (to_seconds(time - track.declined) >= ask_again) {
            for (const FreeRobot& one : open.free) {
                std::erase_if(track.names, [&](const PossibleName& name) { return name.track.is(one.robot) && name.since < one.seen; });
                propose_name(track, one.robot, models);
            }
            if (std::any_of(names.begin(), names.end(), [&](const FreeName& name) { return may_be(track, name, open.free, group, models); })) {
                open.tracks.push_back(t);
                continue;
            }
        }
        open.nats += std::log(no_robot) + way_of_stranger(track);
    }
    open.ways = likely_namings(association, open.tracks, open.free, group, models);
    double sum = 0;
    for (const Naming& way : open.ways) sum += std::exp(way.log_weight - open.ways[0].log_weight);
    const double log_sum = open.ways[0].log_weight + std::log(sum);
    for (Naming& way : open.ways) way.log_weight -= log_sum;
    open.nats += log_sum;
    return open;
}

}  // namespace roomfix
