// Finds the robots of a site by their bodies in what one or several fixed cameras see at the same moment.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "roomfix/observation/absence.hpp"
#include "roomfix/observation/pose_observation.hpp"
#include "roomfix/observation/silhouette_observation.hpp"
#include "roomfix/overhead/body_search.hpp"

namespace roomfix {

/// A robot found by its body.
struct BodySighting {
    int robot = 0;  // index in the site's robots
    BodyPlace place;
    std::vector<BodyPlace> others;          // further places that explain the pictures nearly as well, with their weights
    FixedList<double, most_kinds> kinds{};  // as of a SilhouetteObservation
};

/// A robot whose outline was found: what it explains is not looked at again.
struct KnownRobot {
    int robot = 0;
    Pose2 pose;
    bool sure = true;  // false: it has to explain the pictures better than other robots do
    double edges = 0;  // nats by which the outline's edges speak for it
};

/// What an outline says of its robot.
KnownRobot known_by_outline(const SilhouetteObservation& outline);

/// What is known before a moment is looked at.
struct Expectation {
    std::vector<PoseObservation> things;    // where things should be that are no robots
    std::vector<PoseObservation> robots;    // where robots should be by all that was seen of them before: they are looked for there first
    std::vector<PoseObservation> nameless;  // where something like one of them was seen while all of them are expected elsewhere: tried as well
    // Everywhere, too:
    bool search = true;           // for robots that nobody expects anywhere or that are not where they are expected, and for things
    bool search_outlines = true;  // for exact robots behind others
};

/// Nats by which the edges in a picture speak for a robot where its body was found, and not for something else of about its size. Asked about bodies that
/// have edges.
using EdgeJudge = std::function<double(const BodySighting&)>;

struct BodyObserverSettings {
    BodySearchSettings search;
    double least_probability = 0.5;  // of a body against clutter, to be a sighting
    double plainly_filled = 0.75;    // part of the body's pixels that differ from the background, for an outline to need no further look
    double plainly_alone = 0.15;     // part of the pixels around it that may differ then
    double overlap = 0.8;            // of the circles inside two robots' footprints: nearer to each other than that they cannot stand
    double floor = 100;              // m^2 over which a robot may stand that nobody expects anywhere
    double surprise = 0.02;          // probability that a robot is not where it is expected
    double expected_within = 0.7;    // m, 1 sigma: a robot that is expected no better is looked for everywhere
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

/// Robots that come in any number are not looked for.
class BodyObserver {
public:
    explicit BodyObserver(const std::vector<SiteRobot>& robots, const BodyObserverSettings& settings = {});

    /// `wanted`: a flag for each robot of the site. Likeliest first; what one explains the next ones do not find again. Look-alikes share one
    /// search. `edges`: asked about each body before it is a robot; it may use standing().
    const std::vector<BodySighting>& find(std::span<const SeenBy> cameras, const std::vector<char>& wanted, std::span<const KnownRobot> known = {},
                                          const Expectation& expected = {}, const EdgeJudge& edges = {});
    /// After find(): what stands there and is no robot of the site.
    const std::vector<BodyPlace>& things() const { return things_; }
    /// After find(): robots that are not where they are expected, although the cameras see the place.
    const std::vector<AbsenceObservation>& absent() const { return absent_; }
    /// After find(): all that explains the moment, robots known before and things among it. Things count on behind the last robot.
    std::span<const KnownRobot> standing() const { return standing_; }
    /// After find(): did the robot turn out to stand there? If not, its outline was something else's.
    bool holds(const KnownRobot& known) const;

    /// Does what one camera sees at a robot's outline plainly show its body, and nothing around it?
    bool confirms(const SeenBy& camera, int robot, const Pose2& pose);
    /// Does what one camera sees at a pose speak for the robot's body there?
    bool shows(const SeenBy& camera, int robot, const Pose2& pose);
    /// Does an outline's place explain the pictures about as well as the best place of the body does?
    bool agrees(std::span<const SeenBy> cameras, int robot, const Pose2& pose, const BodyPlace& best);

    /// Does any of the robots want the evidence's colours?
    bool wants_colours() const;

    /// Look-alikes are of one kind.
    std::size_t kind(int robot) const { return kind_of_[static_cast<std::size_t>(robot)]; }
    const Body& body(int robot) const { return bodies_[kind_of_[static_cast<std::size_t>(robot)]]; }

private:
    /// A robot at one of its kind's candidates.
    struct Choice {
        int robot = 0;
        std::size_t candidate = 0;
        Pose2 pose;
        double total = 0;  // nats
    };
    /// Bodies of robots; those of things come behind them.
    std::size_t kinds() const { return bodies_.size() - (kind_of_.size() - robots_); }
    /// What is looked for all over the floor before anything is settled.
    struct SearchTurn {
        bool things_first = false;
        std::optional<std::size_t> kind;  // of robots that are expected
    };
    void begin_moment(std::span<const SeenBy> cameras);
    SearchTurn turn_of_search(bool search);
    void look_where_expected(std::size_t kind);
    void search_everywhere(std::size_t kind);
    bool is_missing(std::size_t kind) const;
    double prior_of(int robot, const Pose2& pose) const;
    double odds_here(const PoseObservation& expected, const Pose2& pose) const;
    static bool is_at(const PoseObservation& thing, const Pose2& pose);
    std::optional<double> prior_of_thing(const Pose2& pose) const;
    int likeliest_of(std::size_t kind, const Pose2& pose) const;
    void weigh_by_prior(std::size_t kind);
    bool is_open(std::size_t kind) const;
    void look_for_things(const Expectation& expected, bool everywhere);
    double most_of_things(int robot, const Pose2& pose);
    bool is_missing_robot(int robot) const;
    bool may_be_missing_robot(const Body& thing, const Pose2& pose) const;
    double odds_against_thing(int robot, std::size_t thing) const;
    bool list_pixels(const SeenBy& camera, const Body& shape, const Pose2& pose);
    const BodyCandidate* thing_instead_of(int robot, const Pose2& pose, double score, bool same_pixels);
    const BodyCandidate* known_thing(double least);
    bool settle_thing(const BodyCandidate& thing);
    void settle_thing_first(const BodyCandidate& thing);
    void settle_things();
    void note_absent();
    bool settle_next(bool only_expected, const EdgeJudge& edges);
    std::vector<Choice> likeliest_together(std::vector<Choice> choices) const;
    std::optional<Choice> choose() const;
    double score_of(const KnownRobot& outline, double trust = 1);
    double odds_of(const KnownRobot& outline);
    double likelier_by(const BodyCandidate& a, const BodyCandidate& b) const;
    double odds_among_kinds(std::size_t kind, const BodyCandidate& candidate) const;
    double explained_beside(int robot, std::size_t kind, const Pose2& pose, double trust);
    bool is_robot(BodySighting& sighting, const EdgeJudge& edges);
    std::vector<KnownRobot>::iterator rather_than(const Choice& choice, bool only_expected);
    std::vector<BodyCandidate> rivals_of(const Choice& choice) const;
    FixedList<double, most_kinds> compare_kinds(std::size_t own, const BodyPlace& place);
    void stand(int robot, const Pose2& pose);
    bool in_the_way(const Body& shape, int robot, const Pose2& pose) const;
    bool stand_in_each_other(const Body& a, const Pose2& at_a, const Body& b, const Pose2& at_b) const;
    void drop_blocked();
    void take_away(const Pose2& pose, const Body& body, std::vector<std::vector<Evidence::Change>>* before = nullptr);
    void put_back();
    void spare_outlines(std::size_t camera, const Pose2& pose, const Body& shape);

    BodyObserverSettings settings_;
    std::vector<Body> bodies_;          // one for all robots that look alike
    std::vector<std::size_t> kind_of_;  // of each robot: which of the bodies is its own
    BodySearch search_;
    std::vector<Evidence> left_;  // of each camera: what is not explained yet
    std::vector<SeenBy> moment_;
    std::vector<std::vector<BodyCandidate>> candidates_;  // of each body
    std::size_t robots_ = 0;                              // of the site; behind them in kind_of_: the things
    bool watches_things_ = false;                         // not where robots come in any number: those are found by other means
    std::vector<BodyPlace> things_;
    std::vector<AbsenceObservation> absent_;
    std::vector<BodySighting> found_;
    // Of the moment that is looked at:
    std::vector<char> open_;                        // of each robot: not settled yet
    std::vector<KnownRobot> unsure_;                // outlines that have to hold yet
    std::vector<KnownRobot> standing_;              // robots that are settled
    std::vector<KnownRobot> strange_;               // where bodies were found that have not the robots' edges
    std::vector<const PoseObservation*> expected_;  // of each robot; null: anywhere
    std::vector<PoseObservation> nameless_;         // where something like a robot was seen
    std::vector<PoseObservation> known_things_;     // where things should be that are no robots
    PlaceMemory memory_;
    std::vector<int> covered_;                                   // pixels of the robot that is taken away
    std::vector<std::pair<std::size_t, std::uint16_t>> spared_;  // pixels of other outlines and what of them may be a shadow
    std::vector<std::vector<Evidence::Change>> on_trial_;        // of each camera, as they were before
    long searches_ = 0;
};

}  // namespace roomfix
