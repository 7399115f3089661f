// Every robot's pose from all that is observed of it: cameras, landmarks, corners, ranges, odometry.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomfix/estimate/group.hpp"
#include "roomfix/estimate/lag_buffer.hpp"
#include "roomfix/estimate/noise_learner.hpp"
#include "roomfix/estimate/tracking_models.hpp"
#include "roomfix/observation/odometry_observation.hpp"

namespace roomfix {

/// What was not used, and why.
struct TrackerCounts {
    long used = 0;
    long late = 0;        // older than the lag
    long twice = 0;       // the same source at the same time
    long impossible = 0;  // not finite, not positive definite, an unknown robot, beacon or camera
    long strayed = 0;     // a time far from all others
};

/// A source that is not believed for a robot at present.
struct Quarantine {
    std::string robot;
    std::string source;
    double distance = 0;             // m, from where the robot is by all other sources
    bool sees_others_right = false;  // another robot's places by the same source are right: it takes something else for this one
};

/// What a tracker was told, for smoothing after the fact.
struct TrackerHistory {
    struct Told {
        std::size_t group = 0;  // of the tracker's groups
        Event event;
    };
    std::vector<Told> events;           // as they came
    std::vector<OdometryTrack> driven;  // of each robot
};

/// Observations may come in any order and up to a lag late; the result is that of processing them in the order of their times.
class Tracker {
public:
    explicit Tracker(const Site& site, const TrackerSettings& settings = {});

    /// One frame of a fixed camera: all robots in it, none of them twice. An empty one counts, too.
    void observe(Nanoseconds time, const std::string& camera, std::span<const PoseObservation> robots);
    /// The tag of one robot in one frame of a fixed camera.
    void observe(Nanoseconds time, const std::string& camera, const TagSighting& sighting);
    /// Landmarks or corners in one frame of a camera on a robot of the site, with the places that the frame alone allows.
    void observe(Nanoseconds time, const std::string& camera, const LandmarkSighting& sighting);
    void observe(Nanoseconds time, const std::string& camera, const CornerSighting& sighting);
    /// A robot that cameras do not see where it should be.
    void observe(Nanoseconds time, const std::string& camera, const AbsenceObservation& absence);
    void observe(const RangeObservation& range);
    void observe(const RangeDifferenceObservation& difference);
    void observe(const SightingObservation& sighting);
    void observe(const OdometryObservation& odometry);
    /// Where a robot may be, found from several observations together: tracking starts or recovers there.
    void propose(Nanoseconds time, const std::string& source, const PlaceSighting& places);

    /// A recording that is read in the order of its times goes on at this one: however long the gap before it, it is no error.
    void go_on(Nanoseconds time);

    /// A robot that is not one of many, at a time not before its last observation; nothing if it is not tracked.
    std::optional<Fix> fix(int robot, Nanoseconds time) const;
    /// Where a robot that is not one of many is expected at a time, if it is tracked and not lost.
    std::optional<PoseObservation> expected(int robot, Nanoseconds time) const;
    /// The same of all robots that are followed, and of look-alikes that have no name yet: each of these as one that is not followed.
    std::vector<PoseObservation> expected(Nanoseconds time) const;
    /// Where something should be seen that looks like one of several robots, while all of these are followed elsewhere: one of them may be lost.
    std::vector<PoseObservation> nameless(Nanoseconds time) const;
    /// All robots at a time; into the past as far as the lag reaches.
    std::vector<Fix> fixes(Nanoseconds time) const;
    /// What is believed of a robot in detail; nothing if it is not tracked.
    const Track* track(int robot) const;

    /// From now on all that is used is kept, too.
    void keep_history();
    const TrackerHistory* history() const { return history_ ? &*history_ : nullptr; }

    const TrackerCounts& counts() const { return counts_; }
    std::vector<Quarantine> quarantines() const;
    const TrackingModels& models() const { return models_; }
    /// The models with what was learned of the robots' senses.
    TrackingModels learned_models() const;
    /// Why a robot that has a place of its own in the site was never found; empty if it was.
    std::string why_not_found(int robot) const;
    const std::vector<Group>& groups() const { return groups_; }
    std::size_t group_of(int robot) const { return group_of_[static_cast<std::size_t>(robot)]; }

private:
    using Buffer = LagBuffer<GroupState, Event>;
    bool plausible_time(Nanoseconds time);
    bool right_for_another(int robot, int source, Nanoseconds time) const;
    bool taken_by_another(Nanoseconds time, const PoseObservation& o) const;
    template <class Sighting, class Seen>
    void observe_onboard(Nanoseconds time, const std::string& camera, const Sighting& sighting, const std::vector<Seen>& seen);
    void add(std::size_t group, const Event& event);
    void learn(std::size_t group, const Event& event);
    Nanoseconds needed_from(std::size_t group) const;
    bool knows_robot(int robot) const { return robot >= 0 && static_cast<std::size_t>(robot) < models_.site.robots.size(); }
    bool knows_beacon(int beacon) const { return beacon >= 0 && static_cast<std::size_t>(beacon) < models_.site.beacons.size(); }

    TrackingModels models_;
    std::vector<Group> groups_;
    std::vector<std::size_t> group_of_;   // of each robot
    std::vector<Buffer> buffers_;         // of each group
    std::vector<NoiseLearner> learners_;  // of each group
    TrackerCounts counts_;
    std::optional<TrackerHistory> history_;
    std::optional<Nanoseconds> newest_;
    std::optional<Nanoseconds> stray_;  // a time that is far from all others, until a second one confirms it
};

}  // namespace roomfix
