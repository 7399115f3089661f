// How well a robot's body at a pose explains what one camera sees.
#pragma once

#include <span>

#include "roomfix/imaging/evidence.hpp"
#include "roomfix/overhead/body.hpp"
#include "roomfix/overhead/look_score.hpp"
#include "roomfix/overhead/near_outlines.hpp"
#include "roomfix/overhead/wall_cover.hpp"

namespace roomfix {

/// The score of a place is the logarithm of a ratio of probabilities (nats): the body's pixels show something else in a part that is not
/// known beforehand (a Beta distribution: bodies have gaps, and colours like the background's), against that they show no more of it than
/// what lies around them. It is the scan statistic of Kulldorff (1997) with the unknown part integrated out instead of maximised.
struct PlaceScoreSettings {
    double core_filled = 3.0;  // Beta distribution of the part of the core's pixels that differ from the background ...
    double core_open = 1.0;    // ... mean 0.75
    double rim_filled = 1.2;   // the same of what lies between the core and the body's outline: even, since bodies are rough
    double rim_open = 1.0;
    double floor_coloured = 0;      // probability that a body with edges is about as dark as what it stands before: any part of its pixels may differ then
    double pixels_per_sample = 15;  // px of the small picture that say as much as one independent one: neighbours are alike
    double least_clutter = 0.02;    // part of the pixels that differ anywhere
    double least_filled = 0.001;    // part of a body's pixels: as much may differ where nothing is
    double usual_weight = 0.25;     // of the body's pixels: so many of the whole picture count along with those around
    double surroundings = 0.5;      // of the body's box, to each side: where clutter is counted
    double hidden = 0.1;            // probability that all of the body is hidden from a camera by something unknown
    double least_whole = 0.1;       // part of the body that must lie in the picture: less says nothing
    // Where it is asked whether a body or a thing of any shape stands at a place: the ring around the body's outline in eight sectors.
    double ring = 1.35;             // of the outline's size: how far out the ring goes
    double something_beside = 0.2;  // probability that a sector shows something beside a body ...
    double goes_on = 0.6;           // ... and that it shows more of a thing that covers the body's pixels
    double beside_differs = 0.05;   // Beta distribution of the part of a sector's pixels that differ where nothing is: its least mean ...
    double beside_samples = 10;     // ... and the sum of its two parameters
    LookSettings look;
};

/// One camera's part of a moment.
struct SeenBy {
    const View* view = nullptr;
    const Evidence* evidence = nullptr;
    const std::vector<Polyline>* walls = nullptr;  // that nobody sees through; null: none
};

/// Working memory.
struct PlaceMemory {
    BodyMask mask;
    BodyMask other;
    std::vector<SeenSpot> spots;
    std::vector<Span> rows;                // of the picture: what the body's outline covers
    std::vector<Eigen::Vector2d> outline;  // the ring's outer edge
};

/// What walls hide from the camera of a body that stands at a place (m, map).
WallCover hidden_from(const SeenBy& camera, const Body& body, const Eigen::Vector2d& place);

/// Part of a body's pixels in all cameras that another one would cover, too.
double covered_part(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, const Body& other, const Pose2& at_other, PlaceMemory& memory);

struct PlaceScore {
    double log_ratio = 0;  // nats, 0: the camera says nothing
    double samples = 0;    // independent pixels of the body in the picture
    double filled = 0;     // part of them that differ from the background
    double around = 0;     // part of the pixels around that do
    double body_like = 0;  // nats, at most 0: how much less differs than where a body usually stands. Of bodies with edges
    double silent = 1;     // part of the body that says nothing: outside the picture, behind a wall, or behind what was taken away before
    bool in_picture = false;
};

/// What walls hide of the body says nothing. Where the body's look is known and the evidence has its colours, they decide instead of how much differs.
/// `coarse`: they are left out. `most_samples`: of a whole body, however large it is in the picture. `near`: the body's outlines around the pose, where they
/// were prepared.
PlaceScore score_place(const SeenBy& camera, const Body& body, const Pose2& pose, const PlaceScoreSettings& settings, PlaceMemory& memory, bool coarse = false,
                       double most_samples = 1e9, const NearBody* near = nullptr);

/// Nats by which what one camera sees at a pose has the body's shape, and not just any: a thing of any shape may cover any part of the body's pixels and,
/// since it does not end where the body would, go on beyond it to any side. 0: the camera says nothing.
double score_shape(const SeenBy& camera, const Body& body, const Pose2& pose, const PlaceScoreSettings& settings, PlaceMemory& memory);

}  // namespace roomfix
