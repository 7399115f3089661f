#include "roomfix/estimate/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/estimate/own_senses.hpp"

namespace roomfix {
namespace {

constexpr Nanoseconds longest_silence = 100'000'000;  // ns: an older state is brought up to date by odometry
constexpr Nanoseconds far_apart = 10'000'000'000;     // ns: no source is that far ahead of or behind the others

constexpr double farthest_place = 1e6;    // m: beyond, a place is a mistake
constexpr double least_variance = 1e-14;  // of anything measured, m^2 or rad^2
constexpr double largest_variance = 1e10;

/// False for what is not finite, too.
bool is_place(const Pose2& pose) { return std::abs(pose.x) < farthest_place && std::abs(pose.y) < farthest_place && std::abs(pose.yaw) < 1e4; }
bool is_sigma(double sigma) { return sigma * sigma >= least_variance && sigma * sigma < largest_variance && sigma > 0; }

bool usable(const PoseObservation& o) {
    if (!is_place(o.pose) || !o.covariance.allFinite() || !o.by_calibration.allFinite() || o.by_calibration.cwiseAbs().maxCoeff() > farthest_place)
        return false;
    const int dimensions = o.yaw_known ? 3 : 2;
    const Eigen::MatrixXd part = o.covariance.topLeftCorner(dimensions, dimensions);
    return Eigen::LLT<Eigen::MatrixXd>(part).info() == Eigen::Success && part.diagonal().minCoeff() >= least_variance &&
           part.diagonal().maxCoeff() < largest_variance;
}

bool usable(const PlaceProposal& p) { return usable(PoseObservation{0, p.pose, p.yaw_known, p.covariance}) && p.weight > 1e-12 && p.weight < 1e12; }

bool usable(const FixedList<PointSighting, 4>& points) {
    return std::all_of(points.begin(), points.end(),
                       [](const PointSighting& p) { return p.pixel.allFinite() && p.covariance.allFinite() && p.covariance.determinant() > 0; });
}

bool usable(const LandmarkObservation& o) { return usable(o.points); }

bool usable(const CornerObservation& o) {
    return o.view.corner_from_camera.allFinite() && o.view.place.allFinite() && o.covariance.allFinite() &&
           Eigen::LLT<Matrix5d>(o.covariance).info() == Eigen::Success;
}

/// Less than all directions that do not look the same are likely.
bool tells_direction(const PoseObservation& o) {
    const double all = 2 * std::numbers::pi / std::max(o.like_turns, 1);
    return o.covariance(2, 2) < all * all / 12;
}

/// Does a sighting stand inside another one of the same frame? Robots of one group cannot: it is the same robot seen twice.
bool stands_inside(const PoseObservation& o, const std::vector<PoseObservation>& others, const SiteRobot& robot) {
    const double least = half_size(robot.shape).head<2>().minCoeff();
    return !robot.many && std::any_of(others.begin(), others.end(),
                                      [&](const PoseObservation& other) { return std::hypot(o.pose.x - other.pose.x, o.pose.y - other.pose.y) < least; });
}

template <class Observation>
bool all_usable(const std::vector<Observation>& all) {
    return std::all_of(all.begin(), all.end(), [](const Observation& o) { return usable(o); });
}

}  // namespace

Tracker::Tracker(const Site& site, const TrackerSettings& settings) : models_(site, settings), groups_(groups_of(site.robots)) {
    group_of_.resize(site.robots.size());
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        for (const int robot : groups_[g].robots) group_of_[static_cast<std::size_t>(robot)] = g;
        buffers_.emplace_back(start_state(groups_[g]), settings.lag);
        learners_.emplace_back();
    }
}

/// A single time far from all others is an error; two that agree are a clock that was set.
bool Tracker::plausible_time(Nanoseconds time) {
    if (!newest_ || std::abs(time - *newest_) < far_apart) {
        newest_ = newest_ ? std::max(*newest_, time) : time;
        stray_.reset();
        return true;
    }
    const bool confirmed = stray_ && std::abs(time - *stray_) < far_apart && time != *stray_;
    stray_ = time;
    if (!confirmed) {
        ++counts_.strayed;
        return false;
    }
    if (time < *newest_) {
        for (std::size_t g = 0; g < groups_.size(); ++g) buffers_[g] = Buffer(start_state(groups_[g]), models_.settings.lag);
        for (OdometryTrack& driven : models_.driven) driven = OdometryTrack(models_.settings.odometry_limits);
    }
    newest_ = time;
    stray_.reset();
    return true;
}

void Tracker::go_on(Nanoseconds time) {
    newest_ = newest_ ? std::max(*newest_, time) : time;
    stray_.reset();
}

void Tracker::add(std::size_t group, const Event& event) {
    const auto run = [&](GroupState& state, const Event& e) { step(state, e, groups_[group], models_); };
    switch (buffers_[group].add(event, run)) {
        case Taken::yes:
            if (std::holds_alternative<TimePassed>(event.what) || std::holds_alternative<AbsenceObservation>(event.what)) break;
            ++counts_.used;
            if (history_) history_->events.push_back({group, event});
            learn(group, event);
            break;
        case Taken::late:
            ++counts_.late;
            break;
        case Taken::twice:
            ++counts_.twice;
            break;
    }
}

/// A robot that is like no other: how its own senses err is learned from time to time, and what was made of them lately is made anew.
void Tracker::learn(std::size_t group, const Event& event) {
    if (!groups_[group].alone() || !models_.settings.learns) return;
    const int robot = groups_[group].robots.front();
    const auto r = static_cast<std::size_t>(robot);
    if (models_.site.robots[r].receivers.empty() && !models_.site.robots[r].detector && models_.driven[r].empty()) return;
    const Track& now = buffers_[group].newest().associations.front().tracks.front();
    if (!now.alive() || now.searched == never) return;  // cameras found it: what its senses state of themselves is believed
    NoiseLearner& learner = learners_[group];
    if (!learner.follows(now)) return learner.begin(now);
    learner.add(event);
    const Nanoseconds until = buffers_[group].newest_time() - models_.settings.lag;
    if (!learner.due(until)) return;
    const Track learned = learner.learn(until, models_);
    buffers_[group].restart(
        until, [&](GroupState& state) { state.associations.front().tracks.front() = learned; },
        [&](GroupState& state, const Event& e) { step(state, e, groups_[group], models_); });
}

TrackingModels Tracker::learned_models() const {
    TrackingModels models = models_;
    for (const Buffer& buffer : buffers_) {
        for (const Track& track : buffer.newest().associations.front().tracks) {
            if (!track.named) continue;
            models.learn(track.robot, track.noise);
            if (track.searched != never) doubt_wheels(models.odometry[static_cast<std::size_t>(track.robot)]);
        }
    }
    return models;
}

std::string Tracker::why_not_found(int robot) const {
    const Track* found = track(robot);
    if (found != nullptr) return "";
    const auto group = group_of(robot);
    for (const Track& one : buffers_[group].newest().associations.front().tracks) {
        if (one.robot == robot && !one.alive()) return roomfix::why_not_found(one, models_);
    }
    return "it was not seen";
}

/// Does a robot of its own look surely stand where this look-alike is seen? Then it is that robot, badly seen.
bool Tracker::taken_by_another(Nanoseconds time, const PoseObservation& o) const {
    constexpr double sure = 0.01;     // m^2, variance of the place
    constexpr double overlap = 0.75;  // of the half widths together
    const std::size_t group = group_of(o.robot);
    if (groups_[group].many) return false;
    const double own = half_size(models_.site.robots[static_cast<std::size_t>(o.robot)].shape).head<2>().minCoeff();
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        if (g == group || !groups_[g].alone() || buffers_[g].empty()) continue;
        for (const Fix& fix : fixes_at(buffers_[g].newest(), time, groups_[g], models_)) {
            const double other = half_size(models_.site.robots[static_cast<std::size_t>(groups_[g].robots.front())].shape).head<2>().minCoeff();
            if (fix.status != FixStatus::ok || fix.covariance.topLeftCorner<2, 2>().trace() > sure) continue;
            if (std::hypot(o.pose.x - fix.pose.x, o.pose.y - fix.pose.y) < overlap * (own + other)) return true;
        }
    }
    return false;
}

void Tracker::observe(Nanoseconds time, const std::string& camera, std::span<const PoseObservation> robots) {
    if (!plausible_time(time)) return;
    const int source = models_.source(camera);
    std::vector<GroupSighting> sightings(groups_.size());
    int key = 0;
    for (PoseObservation o : robots) {
        o.yaw_known &= tells_direction(o);
        if (!knows_robot(o.robot) || !usable(o)) {
            ++counts_.impossible;
            continue;
        }
        const std::size_t group = group_of(o.robot);
        // A tag says which of the look-alikes it is.
        if (groups_[group].alone() || (o.identified && !groups_[group].many)) {
            add(group, {time, source, ++key, o});
        } else if (!stands_inside(o, sightings[group].robots, models_.site.robots[static_cast<std::size_t>(o.robot)]) && !taken_by_another(time, o)) {
            sightings[group].robots.push_back(o);
        }
    }
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        if (groups_[g].alone() || (sightings[g].robots.empty() && buffers_[g].empty())) continue;
        add(g, {time, source, 0, std::move(sightings[g])});
    }
}

void Tracker::observe(Nanoseconds time, const std::string& camera, const TagSighting& sighting) {
    const int source = models_.source(camera);
    const bool known = knows_robot(sighting.robot) && models_.views.contains(source) && models_.site.robots[static_cast<std::size_t>(sighting.robot)].tag;
    if (!known || sighting.corners.size() != 4 || !usable(sighting.corners) || !all_usable(sighting.proposals)) {
        ++counts_.impossible;
        return;
    }
    if (plausible_time(time)) add(group_of(sighting.robot), {time, source, -1 - sighting.robot, sighting});
}

template <class Sighting, class Seen>
void Tracker::observe_onboard(Nanoseconds time, const std::string& camera, const Sighting& sighting, const std::vector<Seen>& seen) {
    const int source = models_.source(camera);
    const bool good = knows_robot(sighting.robot) && models_.onboard.contains(source) && all_usable(sighting.proposals) && all_usable(seen);
    if (!good) ++counts_.impossible;
    if (good && !seen.empty() && plausible_time(time)) add(group_of(sighting.robot), {time, source, 0, sighting});
}

void Tracker::observe(Nanoseconds time, const std::string& camera, const LandmarkSighting& sighting) {
    observe_onboard(time, camera, sighting, sighting.landmarks);
}

void Tracker::observe(Nanoseconds time, const std::string& camera, const CornerSighting& sighting) {
    observe_onboard(time, camera, sighting, sighting.corners);
}

void Tracker::observe(Nanoseconds time, const std::string& camera, const AbsenceObservation& absence) {
    constexpr int first_key = -1'000'000;  // before all that the camera sees
    if (!knows_robot(absence.robot) || !is_place(absence.place) || !(absence.nats <= 0)) {
        ++counts_.impossible;
        return;
    }
    if (plausible_time(time)) add(group_of(absence.robot), {time, models_.source(camera), first_key - absence.robot, absence});
}

void Tracker::observe(const RangeObservation& range) {
    if (!knows_robot(range.robot) || !knows_beacon(range.beacon) || !is_sigma(range.sigma) || !(range.range < farthest_place) || range.range < 0) {
        ++counts_.impossible;
        return;
    }
    if (plausible_time(range.time))
        add(group_of(range.robot),
            {range.time, models_.range_source, 1 + range.beacon + range.receiver * static_cast<int>(models_.site.beacons.size()), range});
}

void Tracker::observe(const RangeDifferenceObservation& difference) {
    const auto [a, b] = difference.beacons;
    if (!knows_robot(difference.robot) || !knows_beacon(a) || !knows_beacon(b) || a == b || !is_sigma(difference.sigma) ||
        !(std::abs(difference.difference) < farthest_place)) {
        ++counts_.impossible;
        return;
    }
    const int key = -1 - a - b * static_cast<int>(models_.site.beacons.size());
    if (plausible_time(difference.time)) add(group_of(difference.robot), {difference.time, models_.range_source, key, difference});
}

void Tracker::observe(const SightingObservation& sighting) {
    const auto landmarks = static_cast<int>(models_.site.landmarks.size());
    const bool range = !sighting.range || (*sighting.range > 0 && *sighting.range < farthest_place && is_sigma(sighting.range_sigma));
    const bool bearing = !sighting.bearing || (std::abs(*sighting.bearing) < 10 && is_sigma(sighting.bearing_sigma));
    if (!knows_robot(sighting.robot) || sighting.landmark >= landmarks || !range || !bearing || (!sighting.range && !sighting.bearing)) {
        ++counts_.impossible;
        return;
    }
    if (!plausible_time(sighting.time)) return;
    // Without names two of one moment differ in what they say.
    const auto what = static_cast<int>(std::lround(1e4 * (sighting.range.value_or(0) + 7 * sighting.bearing.value_or(0))));
    add(group_of(sighting.robot), {sighting.time, models_.sighting_source, sighting.landmark >= 0 ? sighting.landmark : landmarks + std::abs(what), sighting});
}

void Tracker::observe(const OdometryObservation& odometry) {
    if (!knows_robot(odometry.robot) || !is_place(odometry.pose)) {
        ++counts_.impossible;
        return;
    }
    if (!plausible_time(odometry.time)) return;
    if (odometry.time < *newest_ - models_.settings.lag) {
        ++counts_.late;
        return;
    }
    OdometryTrack& driven = models_.driven[static_cast<std::size_t>(odometry.robot)];
    const auto changed = driven.add(odometry.time, odometry.pose);
    if (!changed) {
        ++counts_.twice;
        return;
    }
    ++counts_.used;
    if (history_) history_->driven[static_cast<std::size_t>(odometry.robot)].add(odometry.time, odometry.pose);
    const std::size_t group = group_of(odometry.robot);
    // Where the robot moves later than its wheels say, or sooner.
    const double delay = groups_[group].alone() && !buffers_[group].empty() ? buffers_[group].newest().associations.front().tracks.front().noise.delay : 0;
    buffers_[group].redo_after(*changed + from_seconds(delay), [&](GroupState& state, const Event& e) { step(state, e, groups_[group], models_); });
    if (!buffers_[group].empty() && odometry.time - buffers_[group].newest_time() > longest_silence) {
        add(group, {odometry.time, models_.wheel_source, odometry.robot, TimePassed{odometry.robot}});
    }
    driven.forget_before(needed_from(group));
}

/// The time before which a group's odometry is not needed any more.
Nanoseconds Tracker::needed_from(std::size_t group) const {
    constexpr Nanoseconds longest_start = 120'000'000'000;  // ns that a robot may hear before it is found
    constexpr Nanoseconds longest_delay = 2'000'000'000;    // ns by which a robot may move later than its wheels say
    if (buffers_[group].empty()) return *newest_ - 4 * models_.settings.lag;
    const auto& tracks = buffers_[group].newest().associations.front().tracks;
    Nanoseconds needed = buffers_[group].reach();
    if (groups_[group].alone() && !tracks.front().alive()) needed = std::min(needed, *newest_ - longest_start);
    if (groups_[group].alone() && learners_[group].follows(tracks.front())) needed = std::min(needed, learners_[group].reach());
    return needed - longest_delay;
}

void Tracker::propose(Nanoseconds time, const std::string& source, const PlaceSighting& places) {
    if (!knows_robot(places.robot) || !all_usable(places.proposals)) {
        ++counts_.impossible;
        return;
    }
    if (!places.proposals.empty() && plausible_time(time)) add(group_of(places.robot), {time, models_.source(source), 0, places});
}

void Tracker::keep_history() {
    history_.emplace();
    history_->driven.assign(models_.site.robots.size(), OdometryTrack(models_.settings.odometry_limits));
}

const Track* Tracker::track(int robot) const {
    if (!knows_robot(robot)) return nullptr;
    for (const Track& track : buffers_[group_of(robot)].newest().associations.front().tracks) {
        if (track.is(robot) && track.alive()) return &track;
    }
    return nullptr;
}

std::optional<Fix> Tracker::fix(int robot, Nanoseconds time) const {
    if (!knows_robot(robot)) return std::nullopt;
    const std::size_t group = group_of(robot);
    for (const Fix& fix : fixes_at(buffers_[group].newest(), time, groups_[group], models_)) {
        if (fix.robot == models_.site.robots[static_cast<std::size_t>(robot)].id) return fix;
    }
    return std::nullopt;
}

std::optional<PoseObservation> Tracker::expected(int robot, Nanoseconds time) const {
    const auto found = fix(robot, time);
    if (!found || found->status == FixStatus::none) return std::nullopt;
    return PoseObservation{robot, found->pose, found->yaw_known, found->covariance};
}

std::vector<PoseObservation> Tracker::expected(Nanoseconds time) const {
    std::vector<PoseObservation> all;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        if (groups_[g].many || buffers_[g].empty()) continue;
        const auto some = expected_at(buffers_[g].newest(), time, groups_[g], models_);
        all.insert(all.end(), some.begin(), some.end());
    }
    return all;
}

std::vector<PoseObservation> Tracker::nameless(Nanoseconds time) const {
    std::vector<PoseObservation> all;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        if (groups_[g].many || groups_[g].alone() || buffers_[g].empty()) continue;
        const auto some = nameless_at(buffers_[g].newest(), time, groups_[g], models_);
        all.insert(all.end(), some.begin(), some.end());
    }
    return all;
}

std::vector<Fix> Tracker::fixes(Nanoseconds time) const {
    std::vector<Fix> all;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        if (buffers_[g].empty()) continue;
        const auto run = [&](GroupState& state, const Event& e) { step(state, e, groups_[g], models_); };
        const bool past = time < buffers_[g].newest_time();
        const auto found = past ? fixes_at(buffers_[g].at(time, run), time, groups_[g], models_) : fixes_at(buffers_[g].newest(), time, groups_[g], models_);
        all.insert(all.end(), found.begin(), found.end());
    }
    return all;
}

/// Has the source lately been right about another robot, and does that one not depend on it alone?
bool Tracker::right_for_another(int robot, int source, Nanoseconds time) const {
    constexpr double lately = 10;  // s
    for (const Buffer& buffer : buffers_) {
        for (const Track& track : buffer.newest().associations.front().tracks) {
            for (const SourceHealth& health : track.sources) {
                const bool same = health.source == source && track.robot != robot && !health.quarantined;
                if (same && health.judged > 0 && health.right > models_.settings.readmit_above && to_seconds(time - health.judged_at) < lately) return true;
            }
        }
    }
    return false;
}

std::vector<Quarantine> Tracker::quarantines() const {
    std::vector<Quarantine> all;
    for (const Buffer& buffer : buffers_) {
        for (const Track& track : buffer.newest().associations.front().tracks) {
            for (const SourceHealth& source : track.sources) {
                if (!source.quarantined) continue;
                all.push_back({models_.site.robots[static_cast<std::size_t>(track.robot)].id, models_.source_name(source.source), source.distance,
                               right_for_another(track.robot, source.source, track.time)});
            }
        }
    }
    return all;
}

}  // namespace roomfix
