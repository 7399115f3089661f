// Where robots and things should be by all that was seen of them before, and how much likelier that makes a place.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "roomfix/observation/pose_observation.hpp"

namespace roomfix {

/// What is known before a moment is looked at.
struct Expectation {
    std::vector<PoseObservation> things;    // where things should be that are no robots
    std::vector<PoseObservation> robots;    // where robots should be by all that was seen of them before: they are looked for there first
    std::vector<PoseObservation> nameless;  // where something like one of them was seen while all of them are expected elsewhere: tried as well
    // Everywhere, too:
    bool search = true;           // for robots that nobody expects anywhere or that are not where they are expected, and for things
    bool search_outlines = true;  // for exact robots behind others

    /// Where a robot should be; null: nobody knows.
    const PoseObservation* of(int robot) const {
        const auto found = std::find_if(robots.begin(), robots.end(), [robot](const PoseObservation& expected) { return expected.robot == robot; });
        return found == robots.end() ? nullptr : &*found;
    }
};

struct ExpectedPlacesSettings {
    double floor = 100;      // m^2 over which a robot may stand that nobody expects anywhere
    double surprise = 0.02;  // probability that a robot is not where it is expected
    double within = 0.7;     // m, 1 sigma: a robot that is expected no better is looked for everywhere
};

class ExpectedPlaces {
public:
    explicit ExpectedPlaces(const ExpectedPlacesSettings& settings = {}) : settings_(settings) {}

    /// For a site of so many robots. Robots that are expected stay where they are until the next call.
    void begin(const Expectation& expected, std::size_t robots);

    /// Where a robot should be; null: anywhere.
    const PoseObservation* robot(int robot) const { return robots_[static_cast<std::size_t>(robot)]; }
    std::span<const PoseObservation> things() const { return things_; }
    std::span<const PoseObservation> nameless() const { return nameless_; }

    /// Nats by which a robot is likelier to stand at a pose than anywhere on the floor.
    double prior_of(int robot, const Pose2& pose) const;
    /// The same of a thing; nothing where none is expected.
    std::optional<double> prior_of_thing(const Pose2& pose) const;
    /// Nats by which what is expected is likelier to stand at a pose than anywhere on the floor.
    double odds_here(const PoseObservation& expected, const Pose2& pose) const;
    /// Of something expected that has nothing left to stand on, nats.
    double nowhere() const;

private:
    ExpectedPlacesSettings settings_;
    std::vector<const PoseObservation*> robots_;  // of each robot
    std::vector<PoseObservation> nameless_;       // where something like a robot was seen
    std::vector<PoseObservation> things_;
};

/// Is it where a thing should be by what was seen of it before?
bool is_at_place(const PoseObservation& expected, const Pose2& pose);

}  // namespace roomfix
