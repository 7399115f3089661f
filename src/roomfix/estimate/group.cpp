#include "roomfix/estimate/group.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/estimate/look_alikes.hpp"

namespace roomfix {
namespace {

constexpr double moving_speed = 0.3;   // m/s: a robot without a front looks where it drives
constexpr double sure_of_place = 0.9;  // weight of a place that is believed

Track& track_of(Association& association, int robot, const Group& group) {
    if (group.alone()) return association.tracks.front();
    for (Track& track : association.tracks) {
        if (track.is(robot)) return track;
    }
    Track track;
    track.robot = robot;
    track.named = true;
    association.tracks.push_back(track);
    return association.tracks.back();
}

/// What a robot's own receivers or detector say.
bool is_heard(const Event& event) {
    return std::holds_alternative<RangeObservation>(event.what) || std::holds_alternative<RangeDifferenceObservation>(event.what) ||
           std::holds_alternative<SightingObservation>(event.what);
}

bool followed(const GroupState& state, int robot) {
    return std::any_of(state.associations.begin(), state.associations.end(), [&](const Association& association) {
        return std::any_of(association.tracks.begin(), association.tracks.end(), [&](const Track& t) { return t.is(robot); });
    });
}

/// Looks for one of several look-alikes in what it hears; where it is found, all associations have it.
void seek(GroupState& state, const Event& event, const TrackingModels& models) {
    const int robot = robot_of(event);
    auto sought = std::find_if(state.sought.begin(), state.sought.end(), [&](const Track& t) { return t.robot == robot; });
    if (sought == state.sought.end()) {
        Track track;
        track.robot = robot;
        track.named = true;
        sought = state.sought.insert(state.sought.end(), track);
    }
    take(*sought, event, models);
    if (!sought->alive()) return;
    for (Association& association : state.associations) association.tracks.push_back(*sought);
    state.sought.erase(sought);
}

/// Yaw of a robot that shows none: where it drives, unless it drives any way.
void course_as_yaw(const Belief& belief, bool any_way, Fix& fix) {
    const Eigen::Vector2d velocity = belief.mean.segment<2>(state_vx);
    fix.yaw_known = !any_way && velocity.norm() > moving_speed;
    fix.covariance.row(2).setZero();
    fix.covariance.col(2).setZero();
    fix.covariance(2, 2) = unknown_yaw_variance;
    if (!fix.yaw_known) return;
    fix.pose.yaw = std::atan2(velocity.y(), velocity.x());
    const double across = belief.covariance.block<2, 2>(state_vx, state_vx).trace() / (2 * velocity.squaredNorm());
    fix.covariance(2, 2) = std::min(across + 0.01, unknown_yaw_variance);
}

/// What the other hypotheses add to the covariance of the best: their distance from it, by their weight.
Eigen::Matrix3d spread_around_best(const RobotBelief& robot) {
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Hypothesis& h : robot.hypotheses) {
        Eigen::Vector3d off = h.belief.mean.head<3>() - robot.best().mean.head<3>();
        off.z() = wrap_angle(off.z());
        spread += std::exp(h.log_weight) * off * off.transpose();
    }
    return spread;
}

/// How the robot drives and turns, where more is known of it than before it was seen. The other hypotheses' distance from the best counts as for the pose.
void add_velocity(const Track& track, const TrackingModels& models, Fix& fix) {
    const Belief& best = track.belief.best();
    const bool drives_by_wheels = !models.driven[static_cast<std::size_t>(track.robot)].empty();
    if (drives_by_wheels && !best.yaw_known()) return;  // how fast, but nobody knows where to
    const Eigen::Vector3d velocity = best.velocity();
    Eigen::Matrix3d covariance = best.covariance.block<3, 3>(state_vx, state_vx);
    for (const Hypothesis& h : track.belief.hypotheses) {
        const Eigen::Vector3d off = h.belief.velocity() - velocity;
        covariance += std::exp(h.log_weight) * off * off.transpose();
    }
    const Eigen::Vector3d sideways(-velocity.y(), velocity.x(), 0);  // by which it changes where the front is another one
    covariance += track.doubt(2, 2) * sideways * sideways.transpose();
    if (!covariance.allFinite() || worst_sigma(covariance.topLeftCorner<2, 2>()) >= models.settings.start_speed) return;
    fix.velocity = velocity;
    fix.velocity_covariance = 0.5 * (covariance + covariance.transpose());
}

Fix fix_of(Track track, Nanoseconds time, const TrackingModels& models) {
    const TrackerSettings& settings = models.settings;
    predict(track, time, models);
    Fix fix;
    fix.time = time;
    fix.robot = models.site.robots[static_cast<std::size_t>(track.robot)].id;
    fix.unknown = models.site.robots[static_cast<std::size_t>(track.robot)].unknown;
    if (track.number > 0) fix.robot += fmt::format("-{}", track.number);
    const double unseen = to_seconds(time - track.seen);
    const Belief& best = track.belief.best();
    const double sigma = worst_sigma(best.covariance.topLeftCorner<2, 2>());
    const bool hardly_known = track.hardly_known(time, settings.ok);
    if (sigma > models.site.lost || hardly_known) {
        fix.reason = sigma > models.site.lost ? fmt::format("not seen for {:.1f} s: it may be anywhere within {:.1f} m", unseen, 2 * sigma)
                                              : "it was seen for a moment only";
        return fix;
    }
    if (is_missing(track, settings)) {
        fix.reason = fmt::format("not seen for {:.1f} s, although cameras see the place where it should be", unseen);
        return fix;
    }
    fix.status = unseen > settings.ok ? FixStatus::coasting : FixStatus::ok;
    fix.pose = {best.mean[0], best.mean[1], wrap_angle(best.mean[state_yaw])};
    fix.covariance = best.pose_covariance() + spread_around_best(track.belief) + track.doubt;
    const bool one_of_several = track.belief.best_weight() < sure_of_place;
    if ((one_of_several || !track.doubt.isZero(0)) && worst_sigma(fix.covariance.topLeftCorner<2, 2>()) > models.site.lost) {
        fix.reason = one_of_several
                         ? fmt::format("{} places are possible, the likeliest by {:.0f} %", track.belief.hypotheses.size(), 100 * track.belief.best_weight())
                         : "what it heard and saw so far may as well come from another place: it must drive on";
        fix.status = FixStatus::none;
        return fix;
    }
    fix.yaw_known = best.yaw_known();
    if (!fix.yaw_known) {
        // Ranges tell where the receiver is; the robot's middle is somewhere around it.
        const auto robot = static_cast<std::size_t>(track.robot);
        const double arm = models.receiver(track.robot).receiver.head<2>().squaredNorm();
        const auto heard = [&](const SourceHealth& s) { return s.source == models.range_source && to_seconds(time - s.seen) < settings.ok; };
        if (std::any_of(track.sources.begin(), track.sources.end(), heard)) fix.covariance.topLeftCorner<2, 2>() += 0.5 * arm * Eigen::Matrix2d::Identity();
        course_as_yaw(best, models.motion[robot].drive == Drive::holonomic, fix);
    }
    add_velocity(track, models, fix);
    for (const SourceHealth& source : track.sources) {
        if (to_seconds(time - source.seen) < settings.ok && !source.quarantined) fix.sources.push_back(models.source_name(source.source));
        if (source.judged_at == time && source.dimensions > 0) fix.nis.push_back({models.source_name(source.source), source.nis, source.dimensions});
    }
    if (track.belief.hypotheses.size() > 1) {
        for (const Hypothesis& h : track.belief.hypotheses) {
            if (fix.hypotheses.size() == 8) break;
            fix.hypotheses.push_back({{h.belief.mean[0], h.belief.mean[1], wrap_angle(h.belief.mean[state_yaw])}, std::exp(h.log_weight)});
        }
    }
    return fix;
}

}  // namespace

std::vector<Group> groups_of(const std::vector<SiteRobot>& robots) {
    const std::vector<std::size_t> kinds = kinds_of(robots);
    std::vector<Group> groups;
    for (std::size_t i = 0; i < robots.size(); ++i) {
        const auto may_be = [&](int other) {
            const SiteRobot& of_group = robots[static_cast<std::size_t>(other)];
            return !of_group.many && !robots[i].many && hard_to_tell(of_group, robots[i]);
        };
        Group group{{}, robots[i].many, {}};
        // All groups that have one like it are one group.
        std::erase_if(groups, [&](const Group& other) {
            if (std::none_of(other.robots.begin(), other.robots.end(), may_be)) return false;
            group.robots.insert(group.robots.end(), other.robots.begin(), other.robots.end());
            group.kinds.insert(group.kinds.end(), other.kinds.begin(), other.kinds.end());
            return true;
        });
        group.robots.push_back(static_cast<int>(i));
        group.kinds.push_back(std::min(kinds[i], most_kinds - 1));
        groups.push_back(std::move(group));
    }
    return groups;
}

std::size_t Group::kind_of(int robot) const {
    const auto at = std::find(robots.begin(), robots.end(), robot);
    return at == robots.end() ? 0 : kinds[static_cast<std::size_t>(at - robots.begin())];
}

void temper(GroupState& state, const std::vector<double>& before, Nanoseconds time, const TrackerSettings& settings) {
    std::vector<double> after;
    for (const Association& association : state.associations) after.push_back(association.log_weight);
    state.conviction.temper(before, after, time, settings.conviction);
    for (std::size_t s = 0; s < after.size(); ++s) state.associations[s].log_weight = after[s];
}

double looks_like(const Track& track, int robot, const Group& group) {
    double most = track.as_kind[group.kind_of(robot)];
    for (const std::size_t kind : group.kinds) most = std::max(most, track.as_kind[kind]);
    return track.as_kind[group.kind_of(robot)] - most;
}

GroupState start_state(const Group& group) {
    GroupState state;
    if (group.alone()) {
        Track track;
        track.robot = group.robots.front();
        track.named = true;
        state.associations[0].tracks.push_back(track);
    }
    return state;
}

void put_in_order(GroupState& state) {
    constexpr double likelier = 1.6;  // nats: less is no reason to change names that were given
    auto& associations = state.associations;
    std::stable_sort(associations.begin(), associations.end(), [](const Association& a, const Association& b) { return a.log_weight > b.log_weight; });
    auto shown = std::find_if(associations.begin(), associations.end(), [](const Association& a) { return a.shown; });
    if (shown == associations.end() || associations.front().log_weight - shown->log_weight > likelier) shown = associations.begin();
    std::rotate(associations.begin(), shown, shown + 1);
    for (Association& association : associations) association.shown = &association == &associations.front();
}

void step(GroupState& state, const Event& event, const Group& group, const TrackingModels& models) {
    for (Association& association : state.associations) {
        for (Track& track : association.tracks) {
            if (track.alive()) predict(track, event.time, models);
            for (PossibleName& name : track.names) {
                const Eigen::Vector2d before = name.track.belief.best().mean.head<2>();
                predict(name.track, event.time, models);
                name.way += (name.track.belief.best().mean.head<2>() - before).norm();
            }
        }
    }
    if (std::holds_alternative<TimePassed>(event.what)) return;
    if (const auto* frame = std::get_if<GroupSighting>(&event.what)) {
        take_frame(state, *frame, event, group, models);
        return;
    }
    if (const auto* absence = std::get_if<AbsenceObservation>(&event.what)) {
        for (Association& association : state.associations) {
            for (Track& track : association.tracks) {
                if (track.alive() && track.is(absence->robot)) note_absence(track, *absence, models.settings);
            }
        }
        return;
    }
    if (!group.alone() && is_heard(event) && !followed(state, robot_of(event))) return seek(state, event, models);
    std::vector<double> before;
    for (Association& association : state.associations) {
        before.push_back(association.log_weight);
        association.log_weight += take(track_of(association, robot_of(event), group), event, models);
        std::erase_if(association.tracks, [&](const Track& t) { return !t.alive() && !group.alone(); });
    }
    if (state.associations.size() == 1) {
        state.associations[0].log_weight = 0;
        return;
    }
    temper(state, before, event.time, models.settings);
    double most = -1e300;
    for (const Association& association : state.associations) most = std::max(most, association.log_weight);
    for (Association& association : state.associations) association.log_weight -= most;
    put_in_order(state);
}

namespace {

constexpr const char* name_to_come = "it is in sight, but so are others that look the same: which of them it is shows as soon as it moves";

/// Robots that are in sight, but of which nobody knows yet which they are.
std::vector<Fix> without_names(const Association& association, Nanoseconds time, const Group& group, const TrackingModels& models) {
    std::vector<Fix> fixes;
    for (const int robot : group.robots) {
        const auto may_be = [&](const Track& track) {
            return std::any_of(track.names.begin(), track.names.end(), [&](const PossibleName& name) { return name.track.is(robot); });
        };
        const bool named = std::any_of(association.tracks.begin(), association.tracks.end(), [&](const Track& t) { return t.is(robot); });
        if (named || std::none_of(association.tracks.begin(), association.tracks.end(), may_be)) continue;
        Fix& fix = fixes.emplace_back();
        fix.time = time;
        fix.robot = models.site.robots[static_cast<std::size_t>(robot)].id;
        fix.reason = name_to_come;
    }
    return fixes;
}

}  // namespace

std::vector<Fix> fixes_at(const GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models) {
    std::vector<Fix> fixes = without_names(state.associations.front(), time, group, models);
    for (const Track& track : state.associations.front().tracks) {
        if (!track.alive() || (!track.named && track.number == 0)) continue;
        Fix fix = fix_of(track, time, models);
        if (!group.alone() && !group.many) fix.identity = identity_probability(state, track);
        const bool will_be_told = fix.identity < models.settings.sure_of_name && models.has_mark(track.robot);
        if (will_be_told && fix.status != FixStatus::none && to_seconds(time - track.born) < models.settings.naming) {
            fix.status = FixStatus::none;
            fix.reason = name_to_come;
        }
        fixes.push_back(fix);
    }
    return fixes;
}

namespace {

/// What kind of robot a track without a name is, surely enough that cameras need not look for others there.
constexpr double sure_of_kind = 3;  // nats

/// The robots that are not followed, to tracks without a name: what each looks like most. Indices of robots; -1: none of them.
std::vector<int> guess_names(const std::vector<Track>& tracks, const Group& group) {
    struct Guess {
        std::size_t track = 0;
        int robot = 0;
        double nats = 0;
    };
    std::vector<int> free;
    for (const int robot : group.robots) {
        if (std::none_of(tracks.begin(), tracks.end(), [&](const Track& t) { return t.is(robot) && t.alive(); })) free.push_back(robot);
    }
    std::vector<Guess> guesses;
    for (std::size_t t = 0; t < tracks.size(); ++t) {
        if (!tracks[t].alive() || tracks[t].named) continue;
        for (const int robot : free) {
            const double nats = looks_like(tracks[t], robot, group);
            if (nats > -sure_of_kind) guesses.push_back({t, robot, nats});
        }
    }
    std::stable_sort(guesses.begin(), guesses.end(), [](const Guess& a, const Guess& b) { return a.nats > b.nats; });
    std::vector<int> names(tracks.size(), -1);
    for (const Guess& guess : guesses) {
        const bool given = std::find(names.begin(), names.end(), guess.robot) != names.end();
        if (!given && names[guess.track] < 0) names[guess.track] = guess.robot;
    }
    return names;
}

/// Where the tracks of the association that is shown should be seen: those that are, or are guessed to be, one of the robots, or the others.
std::vector<PoseObservation> places_at(const GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models, bool of_robots) {
    std::vector<PoseObservation> places;
    const std::vector<Track>& tracks = state.associations.front().tracks;
    const std::vector<int> guessed = guess_names(tracks, group);
    for (std::size_t t = 0; t < tracks.size(); ++t) {
        const bool is_robot = tracks[t].named || guessed[t] >= 0;
        if (!tracks[t].alive() || is_robot != of_robots) continue;
        const Fix fix = fix_of(tracks[t], time, models);
        const int robot = tracks[t].named || !is_robot ? tracks[t].robot : guessed[t];
        if (fix.status != FixStatus::none) places.push_back({robot, fix.pose, fix.yaw_known, fix.covariance});
    }
    return places;
}

}  // namespace

std::vector<PoseObservation> expected_at(const GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models) {
    return places_at(state, time, group, models, true);
}

std::vector<PoseObservation> nameless_at(const GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models) {
    return places_at(state, time, group, models, false);
}

double identity_probability(const GroupState& state, const Track& track) {
    double agreeing = 0;
    double all = 0;
    for (const Association& association : state.associations) {
        const double weight = std::exp(association.log_weight);
        all += weight;
        for (const Track& other : association.tracks) {
            if (other.is(track.robot) && other.alive() && pose_distance(track.belief.best(), other.belief.best()) < 25) agreeing += weight;
        }
    }
    return (all > 0 ? agreeing / all : 1) * track.named_by_chance;
}

}  // namespace roomfix
