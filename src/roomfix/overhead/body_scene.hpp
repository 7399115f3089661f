// A moment while robots are found in it by their bodies: who stands where, what may stand where, and what is left to explain.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "roomfix/overhead/body_search.hpp"
#include "roomfix/overhead/expected_places.hpp"
#include "roomfix/overhead/left_over.hpp"

namespace roomfix {

struct BodyObserverSettings {
    BodySearchSettings search;
    ExpectedPlacesSettings expected;
    double least_probability = 0.5;  // of a body against clutter, to be a sighting
    double plainly_filled = 0.75;    // part of the body's pixels that differ from the background, for an outline to need no further look
    double plainly_alone = 0.15;     // part of the pixels around it that may differ then
    double overlap = 0.8;            // of the circles inside two robots' footprints: nearer to each other than that they cannot stand
    int searches_apart = 3;          // of so many, one looks everywhere for a kind of robots that are expected, and one for things
    std::vector<Cylinder> things = {{0.5, 1.7}, {0.6, 0.9}};  // m: a person; a chair or a carton. What they explain better is no robot
    double things_sigma = 0.1;                                // m: how well these sizes fit
    double rarity_of_things = 16;                             // nats: what nothing else explains must be so plain to be a thing ...
    double odds_of_thing = 3;                                 // ... and what may as well be a robot is likelier to be one, by so much ...
    double odds_if_alike = 40;  // ... and this much times the square of the part of both bodies that is common: alike, they explain the same
    double same_pixels = 0.5;   // part of a robot's pixels that a thing covers, too, for both to explain the same
    int most_strange = 4;       // places in a moment at which something stands that has not the robot's edges; beyond, a robot is not looked for
    double outline_loss = 8;    // nats by which the place of an outline may explain the pictures worse than the best place does
};

/// A robot whose outline was found: what it explains is not looked at again.
struct KnownRobot {
    int robot = 0;
    Pose2 pose;
    bool sure = true;  // false: it has to explain the pictures better than other robots do
    double edges = 0;  // nats by which the outline's edges speak for it
};

/// A kind is a robot and all that look like it. Behind the kinds of robots come those of things that are none, and behind the robots a number for each of
/// these.
struct BodyScene {
    explicit BodyScene(const std::vector<SiteRobot>& all_robots, const BodyObserverSettings& all_settings);

    std::size_t kinds() const { return bodies.size() - (kind_of.size() - robots); }
    std::size_t kind(int robot) const { return kind_of[static_cast<std::size_t>(robot)]; }
    const Body& body(int robot) const { return bodies[kind(robot)]; }
    std::span<const SeenBy> moment() const { return left.moment(); }

    /// Has a kind a robot that is not settled?
    bool is_open(std::size_t kind) const;
    /// Is a robot open and expected nowhere?
    bool is_missing_robot(int robot) const { return open[static_cast<std::size_t>(robot)] && !expected.robot(robot); }
    bool is_missing(std::size_t kind) const;
    /// The open robot of a kind that is likeliest to stand at a pose; -1: all of them are settled.
    int likeliest_of(std::size_t kind, const Pose2& pose) const;
    bool stand_in_each_other(const Body& a, const Pose2& at_a, const Body& b, const Pose2& at_b) const;
    /// Would a robot at this pose stand in another one that is settled?
    bool in_the_way(const Body& shape, int robot, const Pose2& pose) const;

    /// All that the cameras see, less what the robots explain that are settled from the start.
    void begin(std::span<const SeenBy> cameras);
    /// Candidates where robots of a kind should be, and where something like them was seen.
    void look_where_expected(std::size_t kind);
    /// Candidates all over the floor, in what nothing explains yet.
    void search_everywhere(std::size_t kind);
    /// A robot or a thing is settled: what it covers explains the other candidates less.
    void stand(int robot, const Pose2& pose);
    /// Leaves out candidates that stand in what is settled, or where something was found that has not the robot's edges.
    void drop_blocked();
    /// What a body covers is left out, until left.put_back().
    void try_away(const Body& shape, const Pose2& pose) { left.try_away({&shape, pose}, outlines_beside(shape, pose)); }

    BodyObserverSettings settings;
    std::size_t robots = 0;            // of the site
    std::vector<std::size_t> kind_of;  // of each robot and thing
    std::vector<Body> bodies;          // of each kind
    bool watches_things = false;       // not where robots come in any number: those are found by other means
    BodySearch search;
    // Of the moment that is looked at:
    LeftOver left;
    ExpectedPlaces expected;
    std::vector<std::vector<BodyCandidate>> candidates;  // of each kind
    std::vector<char> open;                              // of each robot: not settled yet
    std::vector<KnownRobot> unsure;                      // outlines that have to hold yet
    std::vector<KnownRobot> standing;                    // robots and things that are settled
    std::vector<KnownRobot> strange;                     // where bodies were found that have not the robots' edges
    std::vector<BodyPlace> things;                       // settled ones
    PlaceMemory memory;

private:
    void take_away(const Body& shape, const Pose2& pose) { left.take_away({&shape, pose}, outlines_beside(shape, pose)); }
    std::span<const StandingBody> outlines_beside(const Body& shape, const Pose2& pose);
    void weigh_by_prior(std::size_t kind);

    std::vector<StandingBody> beside_;  // working memory
};

}  // namespace roomfix
