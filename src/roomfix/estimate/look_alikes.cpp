#include "roomfix/estimate/look_alikes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "roomfix/base/assignment.hpp"
#include "roomfix/base/decompositions.hpp"
#include "roomfix/estimate/naming.hpp"
#include "roomfix/estimate/track_start.hpp"

namespace roomfix {
namespace {

constexpr double same = 0.5;      // squared distance of poses below which two associations of a robot are one
constexpr double close_call = 6;  // difference of cost (twice the nats) up to which two robots may have been mixed up

const Shape& shape_of(const Track& track, const TrackingModels& models) { return models.site.robots[static_cast<std::size_t>(track.robot)].shape; }

/// Squared Mahalanobis distance in x, y, with what two robots cannot be apart less than.
double distance(const Track& track, const PoseObservation& observation, const TrackingModels& models) {
    const Belief& belief = track.belief.best();
    const Eigen::Vector2d off = Eigen::Vector2d(observation.pose.x, observation.pose.y) - belief.mean.head<2>();
    // A quarter of the size keeps disagreeing cameras and people's swinging arms one target.
    const double slack = models.site.robots[static_cast<std::size_t>(track.robot)].many ? 0.25 * half_size(shape_of(track, models)).x() : 0;
    const Eigen::Matrix2d spread =
        belief.covariance.topLeftCorner<2, 2>() + observation.covariance.topLeftCorner<2, 2>() + slack * slack * Eigen::Matrix2d::Identity();
    return off.dot(spread.inverse() * off);
}

constexpr double most_vague = 15;  // of the cost of a vague guess

/// What a vague guess costs beside a sharp one: twice the logarithm of how much wider it is. Without it a lost robot, which may be anywhere, would
/// take the sighting of one that is known to be there.
double vagueness(const Track& track, const PoseObservation& observation) {
    const Eigen::Matrix2d seen = observation.covariance.topLeftCorner<2, 2>();
    const Eigen::Matrix2d spread = track.belief.best().covariance.topLeftCorner<2, 2>() + seen;
    return std::clamp(std::log(spread.determinant() / (16 * seen.determinant())), 0.0, most_vague);
}

constexpr double kind_sightings = 5;  // so many sightings tell what kind of robot it is as well as any number of them
constexpr double lead_by_chance = 4;  // nats by which a wrong kind may well explain a rough body better than its own kind does
constexpr double most_of_kind = 3;    // nats that looks tell of it: what a description leaves out is the same in all of them

/// Nats by which a sighting is of a kind of robot, beside the group's kind that explains it best; nothing where nobody compared them. Half of the leads below
/// lead_by_chance are of a wrong kind, far larger ones hardly any.
std::optional<double> of_kind(const PoseObservation& observation, std::size_t kind, const Group& group) {
    if (kind >= observation.kinds.size()) return std::nullopt;
    double most = observation.kinds[kind];
    for (const std::size_t other : group.kinds) most = std::max(most, other < observation.kinds.size() ? observation.kinds[other] : most);
    return -std::min(std::pow((most - observation.kinds[kind]) / lead_by_chance, 2), most_of_kind);
}

/// Twice the nats against a sighting of one kind being a robot of another.
double kind_cost(const Track& track, const PoseObservation& observation, const Group& group) {
    if (!track.named || group.kind_of(track.robot) == group.kind_of(observation.robot)) return 0;
    return 2 * std::max(0.0, -of_kind(observation, group.kind_of(track.robot), group).value_or(-kind_sightings * observation.tells_kind));
}

/// Remembers as what kind of robot a track was seen. Nats for the name it has.
double note_kind(Track& track, const PoseObservation& observation, const Group& group) {
    const double looked = track.named ? looks_like(track, track.robot, group) : 0;
    for (std::size_t kind = 0; kind < track.as_kind.size(); ++kind) {
        const double before = track.as_kind[kind];
        if (const auto compared = of_kind(observation, kind, group)) {
            track.as_kind[kind] += (*compared - before) / std::clamp<double>(track.sightings, 1, kind_sightings);
        } else {
            const double limit = std::max(kind_sightings * observation.tells_kind, std::abs(before));
            const double step = kind == group.kind_of(observation.robot) ? observation.tells_kind : -observation.tells_kind;
            track.as_kind[kind] = std::clamp(before + step, -limit, limit);
        }
    }
    return track.named ? looks_like(track, track.robot, group) - looked : 0;
}

/// The pairs of tracks and sightings that may belong together. Sorted by x, so that many robots cost no more than few.
std::vector<PossiblePair> possible_pairs(const Association& association, const GroupSighting& frame, const Group& group, const TrackingModels& models) {
    std::vector<PossiblePair> pairs;
    std::vector<int> order(frame.robots.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    const auto x_of = [&](int i) { return frame.robots[static_cast<std::size_t>(i)].pose.x; };
    std::sort(order.begin(), order.end(), [&](int a, int b) { return x_of(a) < x_of(b); });
    double widest = 0;  // variance
    for (const PoseObservation& o : frame.robots) widest = std::max(widest, o.covariance(0, 0));
    for (std::size_t t = 0; t < association.tracks.size(); ++t) {
        const Track& track = association.tracks[t];
        if (!track.alive()) continue;
        const Belief& belief = track.belief.best();
        const double size = half_size(shape_of(track, models)).x();
        const double reach = std::sqrt(models.settings.like_gate * (belief.covariance(0, 0) + widest + size * size));
        const auto begin = std::lower_bound(order.begin(), order.end(), belief.mean[0] - reach, [&](int i, double x) { return x_of(i) < x; });
        for (auto i = begin; i != order.end() && x_of(*i) <= belief.mean[0] + reach; ++i) {
            const double d = distance(track, frame.robots[static_cast<std::size_t>(*i)], models);
            if (d >= models.settings.like_gate) continue;
            const bool many = models.site.robots[static_cast<std::size_t>(track.robot)].many;
            const PoseObservation& seen = frame.robots[static_cast<std::size_t>(*i)];
            pairs.push_back({static_cast<int>(t), *i, d + (many ? 0 : vagueness(track, seen) + kind_cost(track, seen, group))});
        }
    }
    return pairs;
}

/// The bit of one of the group's robots in Track::beside.
std::uint64_t bit_of(int robot, const Group& group) {
    const auto at = static_cast<std::size_t>(std::find(group.robots.begin(), group.robots.end(), robot) - group.robots.begin());
    return at < 64 ? std::uint64_t{1} << at : 0;
}

/// Where all names are taken, a track without a name is no robot of the group, or it is one of them seen elsewhere than it is thought to be. No frame has
/// shown both then: the track must not take what that robot's own track would take as well.
void charge_strangers(std::vector<PossiblePair>& pairs, const Association& association, Nanoseconds time, const Group& group, const TrackingModels& models) {
    if (group.many || !all_followed(association, time, group, models)) return;
    const auto track_of = [&](const PossiblePair& pair) -> const Track& { return association.tracks[static_cast<std::size_t>(pair.row)]; };
    for (PossiblePair& pair : pairs) {
        const Track& track = track_of(pair);
        const bool may_be_known = !track.named && std::any_of(pairs.begin(), pairs.end(), [&](const PossiblePair& other) {
            return other.column == pair.column && track_of(other).named && (track.beside & bit_of(track_of(other).robot, group)) == 0;
        });
        if (may_be_known) pair.cost -= 2 * std::log(no_robot);
    }
}

double cost_of(const std::vector<PossiblePair>& pairs, int row, int column, double otherwise) {
    for (const PossiblePair& pair : pairs) {
        if (pair.row == row && pair.column == column) return pair.cost;
    }
    return otherwise;
}

/// What was seen, for a robot that it may be: the direction of one kind says nothing about another.
PoseObservation seen_as(int robot, PoseObservation observation, const Group& group) {
    observation.yaw_known &= group.kind_of(robot) == group.kind_of(observation.robot);
    return observation;
}

/// Takes a sighting of what may be a certain robot; returns its log evidence. A direction that says nothing about it may be any: without that a robot of
/// another kind would have less to explain.
double take_as(Track& track, int robot, const PoseObservation& seen, const Event& event, const Group& group, const TrackingModels& models) {
    const PoseObservation as = seen_as(robot, seen, group);
    const double any_direction = seen.yaw_known && !as.yaw_known ? std::log(seen.like_turns / (2 * std::numbers::pi)) : 0;
    return take_pose(track, as, event.source, models, group.many) + any_direction;
}

/// Log evidence of a sighting for a track without a name: of all of it, and of its place alone.
struct PlainEvidence {
    double pose = 0, place = 0;
};

/// Of a sighting's place, without taking it.
double evidence_of_place(Track& track, PoseObservation seen, const Event& event, const Group& group, const TrackingModels& models) {
    std::vector<PossibleName> names = std::move(track.names);
    Track copy = track;
    track.names = std::move(names);
    seen.yaw_known = false;
    return take_pose(copy, seen, event.source, models, group.many);
}

/// Takes a sighting of a track without a name as one of each robot that it may be. The direction of one kind of body, seen in another one, turns with that one
/// and tells nothing of its name.
void weigh_names(Track& track, const PoseObservation& seen, const Event& event, const PlainEvidence& plain, const Group& group, const TrackingModels& models) {
    if (track.names.empty()) return;
    std::vector<double> before = {0}, after = {0};  // first that it is none of them
    for (PossibleName& name : track.names) {
        const PoseObservation as = name.is_stranger() ? seen : seen_as(name.track.robot, seen, group);
        before.push_back(name.evidence);
        after.push_back(name.evidence + take_pose(name.track, as, event.source, models, group.many) -
                        (as.yaw_known == seen.yaw_known ? plain.pose : plain.place));
    }
    track.conviction.temper(before, after, event.time, models.settings.conviction);
    for (std::size_t n = 0; n < track.names.size(); ++n) track.names[n].evidence = after[n + 1] - after[0];
}

void start_track(Association& association, const PoseObservation& observation, const Event& event, const Group& group, const TrackingModels& models) {
    Track track;
    track.robot = group.many ? group.robots.front() : observation.robot;
    note_kind(track, observation, group);
    start(track, places_of(observation, models.fixed.at(event.source)), event.time, models);
    health_of(track, event.source).seen = event.time;
    for (std::size_t r = 0; r < group.robots.size() && !group.many; ++r) propose_name(track, group.robots[r], models);
    if (!track.names.empty()) propose_stranger(track);
    for (PossibleName& name : track.names) {
        if (name.is_stranger() || group.kind_of(name.track.robot) == group.kind_of(observation.robot)) continue;
        start(name.track, places_of(seen_as(name.track.robot, observation, group), models.fixed.at(event.source)), event.time, models);
    }
    association.tracks.push_back(track);
}

/// Takes the sightings as assigned; returns their log evidence.
double take_assigned(Association& association, const std::vector<int>& column_of, const GroupSighting& frame, const Event& event, const Group& group,
                     const TrackingModels& models) {
    double evidence = 0;
    std::vector<char> used(frame.robots.size(), 0);
    const std::size_t old_tracks = association.tracks.size();
    std::uint64_t shown = 0;  // robots of the group
    for (std::size_t t = 0; t < old_tracks && !group.many; ++t) {
        if (association.tracks[t].named && column_of[t] >= 0) shown |= bit_of(association.tracks[t].robot, group);
    }
    for (std::size_t t = 0; t < old_tracks; ++t) {
        Track& track = association.tracks[t];
        const bool watched = std::any_of(track.sources.begin(), track.sources.end(), [&](const SourceHealth& s) { return s.source == event.source; });
        if (watched) track.presence += 0.15 * ((column_of[t] >= 0 ? 1 : 0) - track.presence);
        if (column_of[t] < 0) continue;
        used[static_cast<std::size_t>(column_of[t])] = 1;
        if (!track.named) track.beside |= shown;
        const PoseObservation& seen = frame.robots[static_cast<std::size_t>(column_of[t])];
        PlainEvidence plain;
        const bool of_other_kinds = std::any_of(track.names.begin(), track.names.end(), [&](const PossibleName& name) {
            return !name.is_stranger() && group.kind_of(name.track.robot) != group.kind_of(seen.robot);
        });
        if (of_other_kinds && seen.yaw_known) plain.place = evidence_of_place(track, seen, event, group, models);
        plain.pose = take_as(track, track.named ? track.robot : seen.robot, seen, event, group, models);
        evidence += plain.pose;
        weigh_names(track, seen, event, plain, group, models);
        if (!group.many) evidence += note_kind(track, seen, group);
    }
    // What belongs to no track may be anything anywhere.
    const double stray = std::log(models.settings.outliers) - std::log(models.settings.area * 2 * std::numbers::pi);
    for (std::size_t o = 0; o < frame.robots.size(); ++o) {
        if (used[o]) continue;
        start_track(association, frame.robots[o], event, group, models);
        evidence += stray;
    }
    return evidence;
}

/// Tracks that nothing has confirmed for long; robots with a name of their own are kept while they can be predicted.
void drop_lost(Association& association, Nanoseconds time, const Group& group, const TrackingModels& models) {
    const TrackerSettings& settings = models.settings;
    const std::size_t dropped = std::erase_if(association.tracks, [&](const Track& t) {
        const double unseen = to_seconds(time - t.seen);
        if (t.named) return unseen > settings.forget && (t.belief.best().place_sigma() > 2 * models.site.lost || is_missing(t, settings));
        return unseen > (t.number == 0 ? 2 * settings.ok : settings.forget);
    });
    if (dropped > 0 && !group.many) keep_open(association, time, group, models);
}

/// Of two tracks of like robots that stand inside each other, the one that is seen less is the other's shadow.
void drop_doubles(Association& association, const TrackingModels& models) {
    std::vector<char> shadow(association.tracks.size(), 0);
    for (std::size_t a = 0; a < association.tracks.size(); ++a) {
        if (association.tracks[a].presence >= 0.6) continue;
        const double reach = 2.4 * half_size(shape_of(association.tracks[a], models)).x();
        for (const Track& other : association.tracks) {
            const double apart = (other.belief.best().mean.head<2>() - association.tracks[a].belief.best().mean.head<2>()).norm();
            shadow[a] = static_cast<char>(shadow[a] || (other.presence > association.tracks[a].presence && apart < reach));
        }
    }
    std::size_t i = 0;
    std::erase_if(association.tracks, [&](const Track& t) { return shadow[i++] && !t.named; });
}

bool same_association(const Association& a, const Association& b) {
    for (const Track& track : a.tracks) {
        if (!track.named) continue;
        const auto other = std::find_if(b.tracks.begin(), b.tracks.end(), [&](const Track& t) { return t.is(track.robot); });
        if (other == b.tracks.end() || pose_distance(track.belief.best(), other->belief.best()) > same) return false;
    }
    return true;
}

/// The likeliest first, like ones joined, weights add up to 1.
void merge_and_prune(GroupState& state) {
    auto& associations = state.associations;
    for (Association& association : associations) association.shown = &association == &associations.front();  // copies of it came behind it
    if (associations.size() > 1) {
        std::stable_sort(associations.begin(), associations.end(), [](const Association& a, const Association& b) { return a.log_weight > b.log_weight; });
        const double most = associations[0].log_weight;
        std::vector<Association> kept;
        for (Association& association : associations) {
            association.log_weight -= most;
            if (association.log_weight < least_log_weight) continue;
            const auto alike = std::find_if(kept.begin(), kept.end(), [&](const Association& k) { return same_association(k, association); });
            if (alike != kept.end()) {
                alike->shown |= association.shown;
                alike->log_weight = std::log(std::exp(alike->log_weight) + std::exp(association.log_weight));
            } else if (kept.size() < most_associations) {
                kept.push_back(std::move(association));
            }
        }
        associations = std::move(kept);
    }
    double sum = 0;
    for (const Association& association : associations) sum += std::exp(association.log_weight);
    for (Association& association : associations) association.log_weight -= std::log(sum);
    put_in_order(state);
}

/// Two named robots so close to each other that either sighting may be either robot's: the assignment with the two exchanged.
std::vector<std::vector<int>> close_exchanges(const Association& association, const std::vector<int>& column_of, const std::vector<PossiblePair>& pairs,
                                              double alone) {
    std::vector<std::vector<int>> exchanges;
    for (std::size_t a = 0; a < association.tracks.size(); ++a) {
        for (std::size_t b = a + 1; b < association.tracks.size(); ++b) {
            if (!association.tracks[a].named || !association.tracks[b].named || (column_of[a] < 0 && column_of[b] < 0)) continue;
            const auto cost = [&](std::size_t row, int column) { return column < 0 ? alone : cost_of(pairs, static_cast<int>(row), column, 1e9); };
            const double more = cost(a, column_of[b]) + cost(b, column_of[a]) - cost(a, column_of[a]) - cost(b, column_of[b]);
            if (more > close_call) continue;
            exchanges.push_back(column_of);
            std::swap(exchanges.back()[a], exchanges.back()[b]);
        }
    }
    return exchanges;
}

}  // namespace

void take_frame(GroupState& state, const GroupSighting& frame, const Event& event, const Group& group, const TrackingModels& models) {
    const std::size_t count = state.associations.size();
    std::vector<Association> exchanged;
    std::vector<double> before, before_exchanged;
    for (std::size_t s = 0; s < count; ++s) {
        Association& association = state.associations[s];
        drop_lost(association, event.time, group, models);
        auto pairs = possible_pairs(association, frame, group, models);
        charge_strangers(pairs, association, event.time, group, models);
        const double alone = models.settings.like_gate + (group.many ? 0 : most_vague);
        const std::vector<int> column_of = assign(static_cast<int>(association.tracks.size()), static_cast<int>(frame.robots.size()), pairs, alone);
        if (!group.many) {
            for (const auto& other : close_exchanges(association, column_of, pairs, alone)) {
                Association alternative = association;
                before_exchanged.push_back(association.log_weight);
                alternative.log_weight += take_assigned(alternative, other, frame, event, group, models);
                exchanged.push_back(std::move(alternative));
            }
        }
        before.push_back(association.log_weight);
        association.log_weight += take_assigned(association, column_of, frame, event, group, models);
    }
    for (Association& association : exchanged) state.associations.push_back(std::move(association));
    before.insert(before.end(), before_exchanged.begin(), before_exchanged.end());
    temper(state, before, event.time, models.settings);
    if (group.many) {
        drop_doubles(state.associations[0], models);
        for (Track& track : state.associations[0].tracks) {
            if (track.number == 0 && track.sightings >= models.settings.confirmations) track.number = ++state.numbers_given;
        }
    } else {
        merge_and_prune(state);
        give_names(state, event.time, group, models);
    }
    merge_and_prune(state);
}

}  // namespace roomfix
