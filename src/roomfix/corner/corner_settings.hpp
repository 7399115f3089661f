// What decides whether three lines are taken for a room's corner.
#pragma once

#include "roomfix/corner/corner_fit.hpp"
#include "roomfix/corner/corner_search.hpp"
#include "roomfix/corner/edge_ends.hpp"
#include "roomfix/corner/edge_settler.hpp"
#include "roomfix/corner/line_search.hpp"
#include "roomfix/corner/outside_corner.hpp"
#include "roomfix/corner/parallel_edges.hpp"
#include "roomfix/imaging/edge_points.hpp"

namespace roomfix {

struct CornerSettings {
    EdgePointSettings points;
    LineSearchSettings lines;
    CornerSearchSettings search;
    CornerFitSettings fit;
    ParallelSettings parallel;
    EdgeSettlerSettings faint;
    EdgeEndSettings ends;
    OutsideCornerSettings outside;
    double least_group = 30;         // squared standard deviations, mean of the groups of pieces of an edge: below, it may be chance
    double largest_rival = 0.72;     // of a faint edge's evidence: another line there with more may as well be the edge;
    double sure_group = 40;          // above, a line is an edge even if no piece of it is seen by itself
    double settled = 0.024;          // difference of rotations: a fit that turns a faint edge farther than this from where it was settled is not believed
    double search_capture = 2;       // px: lines of the search are this exact
    std::size_t most_tried = 12;     // candidates whose edges are read
    std::size_t most_refined = 4;    // of them that are fitted to the end
    double worth_it = 0.5;           // part of the best one's score that another explanation has before it is fitted
    double long_edge = 55;           // px at 640 px of width: the longest edge seen is no shorter,
    double second_edge = 40;         // nor is the second,
    double short_edge = 18;          // nor the third
    double least_seen = 0.45;        // of the edges inside the picture, up to 200 px of each, this part must be seen
    double plain_part = 0.8;         // of all three lines: where less is seen,
    double plain_edges = 560;        // px at 640 px of width: it is no less than this
    double straightness = 0.35;      // px: real edges bend this much
    double largest_gap = 70;         // px from the corner to where an edge is seen first
    double second_look = 0.8;        // part of the best candidate's score: what has more is read for a crease, too
    double whole_edge = 0.9;         // part of the walls' edge: where less is seen of a step, it may rather be a crease of which this much is
    double clearly = 0.7;            // of its scatter: what leaves less explains the walls' edge clearly better
    double least_depth = 0.05;       // of the light: a shallower crease is none
    double largest_spread = 12;      // of the pieces' offsets over their variances
    double score_scale = 25;         // px of edges seen that make one of two explanations e times likelier
    double largest_moulding = 0.09;  // of the picture's height: parallel edges this close are a moulding's,
    double moulding_score = 0.6;     // and the lower corner counts if its score is this part of the upper's
    double parallel_lines = 0.03;    // rad: lines of a moulding's edges are parallel to the others' within this
    double read_is_measured = 0.6;   // how likely it is that of a moulding's two corners the one was measured that was read, where the walls' edge ends
    double roll_sigma = 0.17;        // rad: cameras are held upright, about
    double common_tilt = 0.96;       // rad: and look up no more steeply than this (55 deg), about,
    double tilt_sigma = 0.17;        // rad
    double largest_doubt = 6;        // half a squared number of standard deviations from that
    double least_weight = 0.02;      // of an explanation that is reported
    bool by_intrinsics = true;       // tell how the view moves with the camera's numbers; an exact lens needs none of it
};

/// The same with those lengths that are stated at 640 px of width in pixels of the model.
CornerSettings in_pixels_of(const CameraModel& model, CornerSettings settings);

}  // namespace roomfix
