// Which robots the tracks without a name may be, and how likely each way to name them is.
#pragma once

#include "roomfix/estimate/group.hpp"

namespace roomfix {

constexpr double no_robot = 0.03;  // share of new tracks that are none of the group

/// A robot that may be seen elsewhere than it is thought to be, and how likely that is: 1 of one that was not seen yet or has been lost.
struct FreeRobot {
    int robot = 0;
    double elsewhere = 1;
    Nanoseconds seen = never;  // where it is thought to be: until then it was nowhere else

    bool is_missing() const { return elsewhere > 0.5; }
};

/// Picks one of them.
inline auto with_robot(int robot) {
    return [robot](const FreeRobot& free) { return free.robot == robot; };
}

/// Picks the possible name of one of the robots.
inline auto is_of(int robot) {
    return [robot](const PossibleName& name) { return name.track.is(robot); };
}

/// One way to give names to tracks: to each the robot that it is, or none.
struct Naming {
    std::vector<int> robots;        // of each of the tracks; -1: it is none of the group
    std::vector<double> by_chance;  // probability of each name where nothing will ever tell
    std::vector<double> elsewhere;  // as of its FreeName
    std::vector<FreeRobot> free;    // robots that are left
    double log_weight = 0;
};

/// The tracks of an association that may get names now, and the robots whose names they may be.
struct OpenNames {
    std::vector<std::size_t> tracks;
    std::vector<FreeRobot> free;
    std::vector<Naming> ways;  // the likeliest first, weights with sum 1
    double nats = 0;           // what Association::open should be
};

/// Of the tracks that were seen often enough. One that can be no robot of the group, or was found to be none a moment ago, is not named now. Lets tracks be
/// followed as the robots that they may be.
OpenNames open_names(Association& association, Nanoseconds time, const Group& group, const TrackingModels& models);

/// Prior probability that a track is a robot with a name of which so many are to be expected elsewhere.
double prior_of(double elsewhere, const std::vector<FreeRobot>& free);

/// Is every robot of the group likelier where the association has it than anywhere else?
bool all_followed(const Association& association, Nanoseconds time, const Group& group, const TrackingModels& models);

/// Nats for a track's being no robot of the group, by its way: half of what is none moves as evenly as robots do, whose wheels explain their ways well.
double way_of_stranger(const Track& track);

/// Nats for a track's being a certain robot, by its way and its own senses. One whose wheels are unknown moves like anything.
double way_of(int robot, const Track& track, const TrackingModels& models);

/// A track without a name is followed as something that moves evenly, too.
void propose_stranger(Track& track);

/// A track without a name is followed as each of the robots, too, whose wheels will tell.
void propose_name(Track& track, int robot, const TrackingModels& models);

}  // namespace roomfix
