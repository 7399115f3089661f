#include "roomfix/estimate/naming.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr std::size_t most_namings = 128;  // ways to give all names at once that are compared
constexpr double ask_again = 1;            // s until a track that got no name may get one

/// A robot that may be seen elsewhere than it is thought to be, and how likely that is: 1 of one that was not seen yet or has been lost.
struct FreeRobot {
    int robot = 0;
    double elsewhere = 1;
    Nanoseconds seen = never;  // where it is thought to be: until then it was nowhere else

    bool is_missing() const { return elsewhere > 0.5; }
};

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

auto with_robot(int robot) {
    return [robot](const FreeRobot& free) { return free.robot == robot; };
}

/// How many of them are to be expected elsewhere: at least one, where a track is one of them.
double expected_elsewhere(const std::vector<FreeRobot>& free) {
    double sum = 0;
    for (const FreeRobot& f : free) sum += f.elsewhere;
    return std::max(sum, 1.0);
}

auto is_of(int robot) {
    return [robot](const PossibleName& name) { return name.track.robot == robot; };
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

/// Prior probability that a track is a robot with such a name.
double prior_of(double elsewhere, const std::vector<FreeRobot>& free) { return (1 - no_robot) * elsewhere / expected_elsewhere(free); }

/// Nats for a track's being a robot with such a name.
double name_nats(const Track& track, const FreeName& name, const std::vector<FreeRobot>& free, const Group& group) {
    const int robot = name.first.robot;
    const auto own = std::find_if(track.names.begin(), track.names.end(), is_of(robot));
    const double evidence = own == track.names.end() ? 0 : own->evidence;
    return std::log(prior_of(name.elsewhere, free)) + track.as_kind[group.kind_of(robot)] + evidence;
}

/// A robot that is not missing is where it is thought to be, until its wheels have turned and say that it is likelier this track: what stands still is like
/// every robot that does.
bool may_be(const Track& track, const FreeName& name, const std::vector<FreeRobot>& free, const Group& group) {
    constexpr double least_way = 0.3;  // m
    if (name.first.is_missing()) return true;
    const auto own = std::find_if(track.names.begin(), track.names.end(), is_of(name.first.robot));
    if (own == track.names.end() || own->way < least_way) return false;
    return name_nats(track, name, free, group) > std::log(no_robot);
}

/// One way to give names to tracks: to each the robot that it is, or none.
struct Naming {
    std::vector<int> robots;        // of each of the tracks; -1: it is none of the group
    std::vector<double> by_chance;  // probability of each name where nothing will ever tell
    std::vector<double> elsewhere;  // as of its FreeName
    std::vector<FreeRobot> free;    // robots that are left
    double log_weight = 0;
};

/// The likeliest ways to name tracks, weights with sum 1.
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
            longer.back().log_weight += std::log(no_robot);
            for (const FreeName& name : free_names(naming.free, group, models)) {
                if (!may_be(track, name, naming.free, group)) continue;
                Naming& next = longer.emplace_back(naming);
                next.robots.push_back(name.first.robot);
                next.by_chance.push_back(name.by_chance());
                next.elsewhere.push_back(name.elsewhere);
                next.log_weight += name_nats(track, name, naming.free, group);
                std::erase_if(next.free, with_robot(name.first.robot));
            }
        }
        std::stable_sort(longer.begin(), longer.end(), [](const Naming& a, const Naming& b) { return a.log_weight > b.log_weight; });
        if (longer.size() > most_namings) longer.resize(most_namings);
        namings = std::move(longer);
    }
    double sum = 0;
    for (const Naming& naming : namings) sum += std::exp(naming.log_weight - namings[0].log_weight);
    const double norm = namings[0].log_weight + std::log(sum);
    for (Naming& naming : namings) naming.log_weight -= norm;
    return namings;
}

/// Which of the tracks get their names now: those whose name is sure, and those that wheels have had their time to tell.
std::vector<char> ripe_tracks(const Association& association, const std::vector<std::size_t>& tracks, const std::vector<Naming>& namings,
                              const std::vector<FreeRobot>& free, Nanoseconds time, const TrackingModels& models) {
    std::vector<char> ripe;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        double agreeing = 0;
        for (const Naming& naming : namings) agreeing += naming.robots[i] == namings[0].robots[i] ? std::exp(naming.log_weight) : 0;
        Nanoseconds since = never;
        for (const PossibleName& name : association.tracks[tracks[i]].names) {
            const auto known = std::find_if(free.begin(), free.end(), with_robot(name.track.robot));
            if (known != free.end() && known->is_missing()) since = std::max(since, name.since);
        }
        ripe.push_back(agreeing > models.settings.sure_of_name || since == never || to_seconds(time - since) >= models.settings.naming);
    }
    return ripe;
}

/// A name given to one of an association's tracks.
void give_name(Association& association, std::size_t index, int robot, double by_chance, const Group& group) {
    Track& track = association.tracks[index];
    const auto own = std::find_if(track.names.begin(), track.names.end(), is_of(robot));
    association.log_weight += track.as_kind[group.kind_of(robot)];
    if (own != track.names.end()) {
        Track named = std::move(own->track);
        association.log_weight += own->evidence;
        named.as_kind = track.as_kind;
        named.presence = track.presence;
        track = std::move(named);
    }
    track.names.clear();
    track.named = true;
    track.robot = robot;
    track.named_by_chance = by_chance;
}

/// The association with the names of the tracks that are ripe; lost tracks of these names end.
Association with_names(Association association, const std::vector<std::size_t>& tracks, const std::vector<char>& ripe, const Naming& naming,
                       std::vector<FreeRobot> free, Nanoseconds time, const Group& group) {
    std::vector<char> ends(association.tracks.size(), 0);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        if (!ripe[i]) continue;
        if (naming.robots[i] < 0) {
            association.tracks[tracks[i]].declined = time;
            association.log_weight += std::log(no_robot);
            continue;
        }
        for (std::size_t t = 0; t < association.tracks.size(); ++t) ends[t] |= association.tracks[t].is(naming.robots[i]);
        association.log_weight += std::log(prior_of(naming.elsewhere[i], free));
        std::erase_if(free, with_robot(naming.robots[i]));
    }
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        if (ripe[i] && naming.robots[i] >= 0) give_name(association, tracks[i], naming.robots[i], naming.by_chance[i], group);
    }
    for (Track& track : association.tracks) {
        std::erase_if(track.names, [&](const PossibleName& name) {
            const bool followed = std::any_of(association.tracks.begin(), association.tracks.end(), [&](const Track& t) { return t.is(name.track.robot); });
            return followed && std::none_of(free.begin(), free.end(), with_robot(name.track.robot));
        });
    }
    std::size_t i = 0;
    std::erase_if(association.tracks, [&](const Track&) { return ends[i++] != 0; });
    return association;
}

}  // namespace

bool all_followed(const Association& association, Nanoseconds time, const Group& group, const TrackingModels& models) {
    const auto free = free_robots(association, time, group, models);
    return std::none_of(free.begin(), free.end(), [](const FreeRobot& f) { return f.is_missing(); });
}

void propose_name(Track& track, int robot, const TrackingModels& models) {
    if (std::any_of(track.names.begin(), track.names.end(), is_of(robot)) || !models.has_mark(robot)) return;
    PossibleName name{track, 0, track.time};
    name.track.names.clear();
    name.track.robot = robot;
    name.track.named = true;
    track.names.push_back(std::move(name));
}

void give_names(GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models) {
    const std::size_t associations = state.associations.size();
    for (std::size_t s = 0; s < associations; ++s) {
        std::vector<std::size_t> tracks;
        for (std::size_t t = 0; t < state.associations[s].tracks.size(); ++t) {
            const Track& track = state.associations[s].tracks[t];
            const bool asks = !track.named && track.sightings >= models.settings.confirmations && to_seconds(time - track.declined) >= ask_again;
            if (asks) tracks.push_back(t);
        }
        if (tracks.empty()) continue;
        const std::vector<FreeRobot> free = free_robots(state.associations[s], time, group, models);
        if (free.empty()) continue;
        for (const std::size_t t : tracks) {
            Track& track = state.associations[s].tracks[t];
            for (const FreeRobot& one : free) {
                std::erase_if(track.names, [&](const PossibleName& name) { return name.track.robot == one.robot && name.since < one.seen; });
                propose_name(track, one.robot, models);
            }
        }
        const std::vector<FreeName> names = free_names(free, group, models);
        std::erase_if(tracks, [&](std::size_t t) {
            return std::none_of(names.begin(), names.end(), [&](const FreeName& name) { return may_be(state.associations[s].tracks[t], name, free, group); });
        });
        if (tracks.empty()) continue;
        const std::vector<Naming> namings = likely_namings(state.associations[s], tracks, free, group, models);
        const std::vector<char> ripe = ripe_tracks(state.associations[s], tracks, namings, free, time, models);
        if (std::find(ripe.begin(), ripe.end(), 1) == ripe.end()) continue;
        const Association before = state.associations[s];
        std::vector<std::vector<int>> given;
        for (const Naming& naming : namings) {
            std::vector<int> robots;  // of the ripe tracks: ways that differ only in the others are one
            for (std::size_t i = 0; i < tracks.size(); ++i) {
                if (ripe[i]) robots.push_back(naming.robots[i]);
            }
            if (naming.log_weight < least_log_weight || std::find(given.begin(), given.end(), robots) != given.end()) continue;
            if (!given.empty() && state.associations.size() >= most_associations) break;
            Association named = with_names(before, tracks, ripe, naming, free, time, group);
            if (given.empty()) {
                state.associations[s] = std::move(named);
            } else {
                state.associations.push_back(std::move(named));
            }
            given.push_back(std::move(robots));
        }
    }
}

}  // namespace roomfix
