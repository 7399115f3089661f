#include "roomfix/estimate/naming.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace roomfix {
namespace {

/// Which of the tracks get their names now: those whose name is sure, and those that wheels have had their time to tell.
std::vector<char> ripe_tracks(const Association& association, const OpenNames& open, Nanoseconds time, const TrackingModels& models) {
    std::vector<char> ripe;
    for (std::size_t i = 0; i < open.tracks.size(); ++i) {
        double agreeing = 0;
        for (const Naming& way : open.ways) agreeing += way.robots[i] == open.ways[0].robots[i] ? std::exp(way.log_weight) : 0;
        Nanoseconds since = never;
        for (const PossibleName& name : association.tracks[open.tracks[i]].names) {
            if (name.is_stranger()) continue;
            const auto known = std::find_if(open.free.begin(), open.free.end(), with_robot(name.track.robot));
            if (known != open.free.end() && known->is_missing()) since = std::max(since, name.since);
        }
        ripe.push_back(agreeing > models.settings.sure_of_name || since == never || to_seconds(time - since) >= models.settings.naming);
    }
    return ripe;
}

/// A name given to one of an association's tracks.
void give_name(Association& association, std::size_t index, int robot, double by_chance, const Group& group, const TrackingModels& models) {
    Track& track = association.tracks[index];
    const auto own = std::find_if(track.names.begin(), track.names.end(), is_of(robot));
    association.log_weight += looks_like(track, robot, group) + way_of(robot, track, models);
    if (own != track.names.end()) {
        Track named = std::move(own->track);
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
Association with_names(Association association, const OpenNames& open, const std::vector<char>& ripe, const Naming& naming, Nanoseconds time,
                       const Group& group, const TrackingModels& models) {
    const std::vector<std::size_t>& tracks = open.tracks;
    std::vector<FreeRobot> free = open.free;
    std::vector<char> ends(association.tracks.size(), 0);
    association.log_weight -= std::exchange(association.open, 0);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        if (!ripe[i]) continue;
        if (naming.robots[i] < 0) {
            association.tracks[tracks[i]].declined = time;
            continue;
        }
        for (std::size_t t = 0; t < association.tracks.size(); ++t) ends[t] |= association.tracks[t].is(naming.robots[i]);
        association.log_weight += std::log(prior_of(naming.elsewhere[i], free));
        std::erase_if(free, with_robot(naming.robots[i]));
    }
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        if (ripe[i] && naming.robots[i] >= 0) give_name(association, tracks[i], naming.robots[i], naming.by_chance[i], group, models);
    }
    for (Track& track : association.tracks) {
        std::erase_if(track.names, [&](const PossibleName& name) {
            if (name.is_stranger()) return false;
            const bool followed = std::any_of(association.tracks.begin(), association.tracks.end(), [&](const Track& t) { return t.is(name.track.robot); });
            return followed && std::none_of(free.begin(), free.end(), with_robot(name.track.robot));
        });
    }
    std::size_t i = 0;
    std::erase_if(association.tracks, [&](const Track&) { return ends[i++] != 0; });
    association.open = open_names(association, time, group, models).nats;
    association.log_weight += association.open;
    return association;
}

}  // namespace

void keep_open(Association& association, Nanoseconds time, const Group& group, const TrackingModels& models) {
    association.open = open_names(association, time, group, models).nats;
}

void give_names(GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models) {
    const std::size_t associations = state.associations.size();
    for (std::size_t s = 0; s < associations; ++s) {
        Association& association = state.associations[s];
        const OpenNames open = open_names(association, time, group, models);
        association.log_weight += open.nats - association.open;
        association.open = open.nats;
        const std::vector<char> ripe = ripe_tracks(association, open, time, models);
        if (std::find(ripe.begin(), ripe.end(), 1) == ripe.end()) continue;
        const Association before = association;
        std::vector<std::vector<int>> given;
        for (const Naming& naming : open.ways) {
            std::vector<int> robots;  // of the ripe tracks: ways that differ only in the others are one
            for (std::size_t i = 0; i < open.tracks.size(); ++i) {
                if (ripe[i]) robots.push_back(naming.robots[i]);
            }
            if (naming.log_weight < least_log_weight || std::find(given.begin(), given.end(), robots) != given.end()) continue;
            if (!given.empty() && state.associations.size() >= most_associations) break;
            Association named = with_names(before, open, ripe, naming, time, group, models);
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
