// Things that are no robots: people, chairs, cartons. What they explain better is no robot.
#pragma once

#include "roomfix/overhead/body_scene.hpp"

namespace roomfix {

/// Candidates for things: where they should be and, if asked for, everywhere.
void look_for_things(BodyScene& scene, bool everywhere);

/// The thing that explains better than a robot at this pose what both would explain, each with the best that the other kind makes of what it leaves;
/// null: the robot does. All samples share the errors of the descriptions, so that only a part of the scores counts.
/// `same_pixels`: things that stand elsewhere on the floor but cover much of the robot's pixels are asked, too: a person's head has its place on the floor
/// far behind the person.
const BodyCandidate* thing_instead_of(BodyScene& scene, int robot, const Pose2& pose, double score, bool same_pixels);

/// Where a thing explains more than a robot of one kind: does an open robot of another kind explain it so well that it is no thing after all?
bool may_be_other_robot(BodyScene& scene, int robot, const BodyCandidate& thing);

/// A thing that was seen before, is no robot that is missing and stands there more surely than `least` nats; null: none.
const BodyCandidate* known_thing(BodyScene& scene, double least);

/// A thing before robots: they are looked for anew in what it leaves.
void settle_thing_first(BodyScene& scene, const BodyCandidate& thing);

/// What no robot explains, the plainest first.
void settle_things(BodyScene& scene);

}  // namespace roomfix
