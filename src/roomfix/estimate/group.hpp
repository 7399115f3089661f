// Robots that can be taken for each other, tracked together: who is who over time.
#pragma once

#include <vector>

#include "roomfix/estimate/conviction.hpp"
#include "roomfix/estimate/track.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix {

/// One robot that looks like no other, several that look alike or nearly so, or any number of one kind.
struct Group {
    std::vector<int> robots;  // indices in the site's robots
    bool many = false;
    std::vector<std::size_t> kinds{};  // of each of `robots`, as in kinds_of(): those of one kind look alike

    /// Kind of one of the robots.
    std::size_t kind_of(int robot) const;

    bool alone() const { return robots.size() == 1 && !many; }
};

/// The robots of a site, in groups of those that pictures may take for each other.
std::vector<Group> groups_of(const std::vector<SiteRobot>& robots);

/// An association hypothesis: which track is which robot.
struct Association {
    double log_weight = 0;
    double open = 0;     // of log_weight: what tracks without a name add, whichever robots they are, so that a name that is given late counts no less
    bool shown = false;  // its fixes are the ones that are given
    std::vector<Track> tracks;
};

/// Nats, at most 0: for a track's being of a robot's kind, beside the kind that it looks like most. What is no robot looks like one of the kinds, too.
double looks_like(const Track& track, int robot, const Group& group);

/// All that is believed of a group. First stands the association that is shown: the likeliest, or one not much less likely that was shown before, so that
/// names do not change back and forth where nothing tells robots apart.
struct GroupState {
    std::vector<Association> associations = {Association{}};
    std::vector<Track> sought;  // robots that are heard or detect something, but have not been found
    int numbers_given = 0;
    Conviction conviction;  // in who is who
};

/// Evidence since the associations had these weights counts as far as it may turn their balance.
void temper(GroupState& state, const std::vector<double>& before, Nanoseconds time, const TrackerSettings& settings);

GroupState start_state(const Group& group);

/// Brings the association to be shown to the front, the others by their weights behind it.
void put_in_order(GroupState& state);

/// The state after an event.
void step(GroupState& state, const Event& event, const Group& group, const TrackingModels& models);

/// All robots of the group at a time not before the state's: ok, coasting, or none with the reason where a robot was lost.
std::vector<Fix> fixes_at(const GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models);

/// Where robots of the group should be seen at a time not before the state's, those without a name among them: these count as robots that are not followed.
std::vector<PoseObservation> expected_at(const GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models);

/// Where something should be seen that looks like a robot of the group, while all of them are followed elsewhere.
std::vector<PoseObservation> nameless_at(const GroupState& state, Nanoseconds time, const Group& group, const TrackingModels& models);

/// Probability that the robot's name is right, 0..1: the weight of all associations that put it there.
double identity_probability(const GroupState& state, const Track& track);

}  // namespace roomfix
