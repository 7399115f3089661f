// What a fixed camera takes for granted when it looks for robots.
#pragma once

#include "roomfix/imaging/background_model.hpp"
#include "roomfix/overhead/body_scene.hpp"
#include "roomfix/overhead/outline_fit.hpp"
#include "roomfix/overhead/place_search.hpp"

namespace roomfix {

/// One camera asks the edges of a body, so that bodies count that hardly differ from what they stand before.
inline BodyObserverSettings bodies_with_edges() {
    BodyObserverSettings settings;
    settings.search.score.floor_coloured = 0.1;
    return settings;
}

struct OverheadSettings {
    BackgroundSettings background;
    OutlineFitSettings fit;
    PlaceSearchSettings search;
    BodyObserverSettings body = bodies_with_edges();
    double surely_exact = 3;        // nats of all that was seen of a kind of robot, for its outlines to be as exact as they state
    double most_exact = 12;         // nats that are remembered of it ...
    double exact_at_once = 2;       // ... and that one outline may tell
    double least_score = 0.40;      // of an outline fit, to be a fix
    double good_score = 0.60;       // above, no other place is tried
    int least_into_shadow = 4;      // samples of the lower edges that lead into what may be a shadow, to look for the robot behind it
    double least_hidden = 0.24;     // part of the outline that must agree where the rest is hidden
    double surely_filled = 0.85;    // part of the silhouette that is foreground, where the outline alone does not convince
    double least_lead = 0.15;       // of a robot's quality before the next robot's, to know which one it is
    double least_visible = 0.25;    // part of the outline in view
    double rough_parts = 0.012;     // m: how far the sides of a body that is described by its parts are off, where it is not exactly so
    double described = 1.5;         // nats by which such a body, found by its area, stands as its outline says, before its edges are looked at
    double described_at_once = 4;   // nats of that which one outline may tell
    double surely_robot = 0.7;      // probability that what was found by its area is the robot, for what its outline says of the description
    int outline_turns = 8;          // in which its outline is tried where nobody knows how it is turned
    double outline_aside = 1.5;     // deviations of the place that the area tells: so far off it is tried, too, where no edges are in reach
    double turn_known = 0.3;        // rad (1 sigma): where it is known
    double least_filled = 0.42;     // part of the silhouette that is foreground, for many soft targets
    double least_in_picture = 0.5;  // part of a soft target's silhouette that must be in the picture
    double least_left = 0.2;        // part of a silhouette that must be unexplained foreground to look for another robot
    double expected_within = 0.5;   // m, 1 sigma: a robot that is expected no better is looked for everywhere
    double expected_gate = 25;      // squared Mahalanobis distance from where it is expected, up to which an outline found there is the robot's
    int most_blobs = 32;
    int most_searches = 1;  // for outlines of which a part is hidden, in a frame
    int most_starts = 6;    // places of a soft target climbed from
};

}  // namespace roomfix
