// One robot under way: what is believed of it, and how each kind of observation changes that.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "roomfix/estimate/conviction.hpp"
#include "roomfix/estimate/event.hpp"
#include "roomfix/estimate/robot_belief.hpp"
#include "roomfix/estimate/start_cloud.hpp"
#include "roomfix/estimate/tracking_models.hpp"

namespace roomfix {

/// Before any time that a clock shows.
constexpr Nanoseconds never = std::numeric_limits<Nanoseconds>::min() / 2;

/// How a source gets on with what is believed otherwise.
struct SourceHealth {
    int source = 0;
    Nanoseconds seen = never;  // its last observation that was believed
    double right = 1;          // smoothed probability that it is right, of observations that something else can confirm
    int judged = 0;
    double distance = 0;  // m, smoothed: how far off it is
    bool quarantined = false;
    double nis = 0;  // of its last observation, with its dimensions
    int dimensions = 0;
    Nanoseconds judged_at = never;
};

/// Nats that one event may turn the balance between hypotheses by at most.
constexpr double most_budget = 5;

struct PossibleName;

struct Track {
    int robot = -1;  // index in the site's robots: itself, or the first of its look-alikes while nobody knows which one
    int number = 0;  // of a robot of which there are many; 0: not reported yet
    bool named = false;
    RobotBelief belief;
    Nanoseconds time = 0;  // of the belief
    Nanoseconds born = 0;
    Nanoseconds seen = 0;  // last observation that was believed
    int sightings = 0;
    Nanoseconds declined = never;              // when it last got no name
    std::vector<PossibleName> names;           // of a track without one: the robots that it may be and whose wheels will tell
    Conviction conviction;                     // in one of them
    double named_by_chance = 1;                // probability of its name where it was given to one of several that nothing will ever tell apart
    std::array<double, most_kinds> as_kind{};  // nats by which it was seen as a robot of each kind
    std::uint64_t beside = 0;                  // of a track without a name: robots of its group, a bit each, that some frame showed together with it
    double presence = 1;                       // part of the last frames of its cameras that showed it
    double absence = 0;                        // nats, at most 0: for its being where it should be, since it was seen there last
    Nanoseconds absent_at = never;             // when cameras said so last
    double budget = most_budget;               // nats, how far evidence may still turn the balance between hypotheses
    FixedList<SourceHealth, 12> sources;
    SenseNoise noise;                                 // of its own senses, as learned
    StartCloud cloud;                                 // where it may be, until it is found
    bool seeks = true;                                // it is sought anew where its senses contradict its place
    std::vector<Heard> heard;                         // lately by its receivers and its detector
    Eigen::Matrix3d doubt = Eigen::Matrix3d::Zero();  // x, y, yaw: how far off it is if its senses found it elsewhere than it was; beside the belief's
    double evidence = 0;                              // nats: log density of all that was taken since it was found, as it was expected before
    long weighed = 0;                                 // how many observations that rests on
    double agreement = 1;                             // smoothed probability that what it hears is right
    Nanoseconds searched = never;                     // when its place was last sought from what it heard

    bool alive() const { return !belief.hypotheses.empty(); }
    /// Is it known to be this robot?
    bool is(int known_robot) const { return named && robot == known_robot; }
    /// Not seen for longer than it was seen: perhaps it never was there.
    bool hardly_known(Nanoseconds now, double patience) const { return to_seconds(now - seen) > patience + 2 * to_seconds(seen - born); }
};

/// A track without a name as it would be if it were a certain robot, moved by that one's wheels, or something without a name that moves evenly.
struct PossibleName {
    Track track;
    double evidence = 0;    // nats for this name against no name
    Nanoseconds since = 0;  // its wheels count from here on
    double way = 0;         // m by which they have moved it

    bool is_stranger() const { return !track.named; }
};

/// Cameras see where it should be, but not the robot.
void note_absence(Track& track, const AbsenceObservation& observation, const TrackerSettings& settings);

/// Probability that it is elsewhere than where it should be, since cameras do not see it there.
double probability_elsewhere(const Track& track, const TrackerSettings& settings);

/// Is it likelier elsewhere? The next sighting starts it anew.
bool is_missing(const Track& track, const TrackerSettings& settings);

/// Moves a track to a time, by odometry where there is any. Not into the past.
void predict(Track& track, Nanoseconds time, const TrackingModels& models);

/// Takes an observation of the track's own robot; the track is at its time. Returns the log evidence, 0 where it starts the track.
double take(Track& track, const Event& event, const TrackingModels& models);
/// The same for one robot of a frame. `certain`: that it is this one has been settled elsewhere.
double take_pose(Track& track, const PoseObservation& observation, int source, const TrackingModels& models, bool certain = false);

/// Health of a source within a track, added if it is not there.
SourceHealth& health_of(Track& track, int source);

}  // namespace roomfix
