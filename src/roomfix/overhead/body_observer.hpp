// Finds the robots of a site by their bodies in what one or several fixed cameras see at the same moment.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "roomfix/observation/absence.hpp"
#include "roomfix/observation/pose_observation.hpp"
#include "roomfix/observation/silhouette_observation.hpp"
#include "roomfix/overhead/body_choice.hpp"

namespace roomfix {

/// A robot found by its body.
struct BodySighting {
    int robot = 0;  // index in the site's robots
    BodyPlace place;
    std::vector<BodyPlace> others;          // further places that explain the pictures nearly as well, with their weights
    FixedList<double, most_kinds> kinds{};  // as of a SilhouetteObservation
};

/// What an outline says of its robot.
KnownRobot known_by_outline(const SilhouetteObservation& outline);

/// Nats by which the edges in a picture speak for a robot where its body was found, and not for something else of about its size. Asked about bodies that
/// have edges.
using EdgeJudge = std::function<double(const BodySighting&)>;

/// Robots that come in any number are not looked for.
class BodyObserver {
public:
    explicit BodyObserver(const std::vector<SiteRobot>& robots, const BodyObserverSettings& settings = {});

    /// `wanted`: a flag for each robot of the site. Likeliest first; what one explains the next ones do not find again. Look-alikes share one
    /// search. `edges`: asked about each body before it is a robot; it may use standing().
    const std::vector<BodySighting>& find(std::span<const SeenBy> cameras, const std::vector<char>& wanted, std::span<const KnownRobot> known = {},
                                          const Expectation& expected = {}, const EdgeJudge& edges = {});
    /// After find(): what stands there and is no robot of the site.
    const std::vector<BodyPlace>& things() const { return scene_.things; }
    /// After find(): robots that are not where they are expected, although the cameras see the place.
    const std::vector<AbsenceObservation>& absent() const { return absent_; }
    /// After find(): all that explains the moment, robots known before and things among it. Things count on behind the last robot.
    std::span<const KnownRobot> standing() const { return scene_.standing; }
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
    std::size_t kind(int robot) const { return scene_.kind(robot); }
    const Body& body(int robot) const { return scene_.body(robot); }

private:
    /// What is looked for all over the floor before anything is settled.
    struct SearchTurn {
        bool things_first = false;
        std::optional<std::size_t> kind;  // of robots that are expected
    };
    SearchTurn turn_of_search(bool search);
    bool settle_next(bool only_expected, const EdgeJudge& edges);
    void settle_outline(std::vector<KnownRobot>::iterator outline, double nats);
    void settle_body(const BodyChoice& choice, const EdgeJudge& edges);
    bool is_robot(BodySighting& sighting, const EdgeJudge& edges);
    void note_absent();

    BodyScene scene_;
    std::vector<BodySighting> found_;
    std::vector<AbsenceObservation> absent_;
    long searches_ = 0;
};

}  // namespace roomfix
