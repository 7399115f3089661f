// Which robot is settled next, and where: what all open robots explain together decides.
#pragma once

#include <optional>
#include <vector>

#include "roomfix/overhead/body_scene.hpp"

namespace roomfix {

/// A robot at one of its kind's candidates.
struct BodyChoice {
    int robot = 0;
    std::size_t candidate = 0;
    Pose2 pose;
    double total = 0;  // nats
};

/// All open robots at once, so that they explain most together; of these the robot that explains most by itself. One after the other, a robot would take the
/// place of another of nearly its size.
std::optional<BodyChoice> choose_robot(const BodyScene& scene);

/// Nats that an outline explains, with what its edges and what was seen before say. `trust`: part of the score that counts.
double outline_score(BodyScene& scene, const KnownRobot& outline, double trust = 1);

/// Nats by which an outline's robot stands there, and neither nothing nor a thing of any shape. A body found in its way that explains more is likelier, and
/// all of the difference counts: an outline says that the robot is the very solid that is described.
double outline_odds(BodyScene& scene, const KnownRobot& outline);

/// One body may cover what two robots show, one before the other, and explain more than either of them: an outline with which the robots together explain
/// more than with the body in its place. All samples share the errors of the descriptions, so that only a part of the scores counts.
/// `only_expected`: of robots that are expected somewhere. The end of `scene.unsure` where there is none.
std::vector<KnownRobot>::iterator rather_than(BodyScene& scene, const BodyChoice& choice, bool only_expected);

/// What the open robots and the things that are known explain together of what a body of `kind` at a pose leaves, each robot at a place of its own, nats. The
/// body is that of `robot`, or a thing's: then the robot stands elsewhere, too. One that is expected and has nothing left to stand on is a surprise.
double explained_beside(BodyScene& scene, int robot, std::size_t kind, const Pose2& pose, double trust);

/// A robot's candidate with those that may be the same robot: the next best places elsewhere are those of its look-alikes.
std::vector<BodyCandidate> rivals_of(const BodyScene& scene, const BodyChoice& choice);

/// How well robots of each kind explain what stands at a place where one of `own` kind was found.
FixedList<double, most_kinds> compare_kinds(BodyScene& scene, std::size_t own, const BodyPlace& place);

}  // namespace roomfix
