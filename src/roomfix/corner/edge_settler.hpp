// Pieces of a faint edge are easily led astray by what is beside it; its light along its whole length is not.
#pragma once

#include <optional>
#include <vector>

#include "roomfix/corner/corner_fit.hpp"
#include "roomfix/corner/faint_edge.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct EdgeSettlerSettings {
    FaintEdgeSettings light;
    double plain_group = 90;  // squared standard deviations, mean of the groups of pieces of an edge: above, it stays where it is
    double apart = 0.016;     // rad: another line is more than this beside it
    double span = 0.1;        // rad: its direction is looked for this far to both sides
    double turn = 0.5;        // rad, about: the camera turns no more by that
    double plainer = 1.12;    // times the evidence that another direction must have
};

struct SettledEdge {
    CornerEdge edge = x_edge;
    double mean = 0;     // squared standard deviations of its groups of pieces
    double rival = 0;    // part of its evidence that the next best line there has,
    CornerView beside;   // the view if that line were the edge, or as it was if that is no corner
    bool moved = false;  // the view
};

class EdgeSettler {
public:
    EdgeSettler(const CameraModel& model, const LightTable& light, const EdgeSettlerSettings& settings = {})
        : settings_(settings), light_(light), edges_(model, settings.light) {}

    /// The edge whose pieces show the least.
    CornerEdge faintest(const CornerFit& fit) const;

    /// Turns the edge to where its light is the plainest, and the view with it.
    SettledEdge settle(LumaView frame, double wall_angle, CornerEdge edge, EdgeKind kind, CornerView& view);

    const FaintEdges& edges() const { return edges_; }

private:
    std::optional<CornerView> turned(const CornerRays& rays, double wall_angle, CornerEdge edge, double turn, const CornerView& view) const;

    EdgeSettlerSettings settings_;
    LightTable light_;
    FaintEdges edges_;
    std::vector<FaintEdges::Peak> peaks_;  // working memory
};

}  // namespace roomfix
