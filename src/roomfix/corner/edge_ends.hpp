// Do a corner's edges end where they meet?
#pragma once

#include "roomfix/corner/corner_fit.hpp"
#include "roomfix/corner/edge_step.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct EdgeEndSettings {
    double beyond_from = 3;     // px: from here ...
    double beyond_to = 11;      // ... to here beyond the corner no edge goes on
    double in_shadow = 0.3;     // part of its contrast that an edge keeps in a shadow, whose corner this may be ...
    double far_beyond = 35;     // ... if it goes on up to here, px
    double plainly_beyond = 4;  // standard deviations of an edge that goes on beyond the corner
    double plainly_above = 8;   // and of the walls' edge above a moulding: its mitre draws much the same
};

class EdgeEnds {
public:
    EdgeEnds(const CameraModel& model, const LightTable& light, const EdgeEndSettings& settings = {}) : model_(model), light_(light), settings_(settings) {}

    /// The edges along the ceiling end at the corner: one that goes on belongs to something else, such as the other side of a moulding. The
    /// walls' edge is not asked: it may seem to go on in a moulding's mitre.
    bool end_at_corner(LumaView frame, const CornerFit& fit, double wall_angle) const;

    /// Does the edge between the walls go on right above the corner, for `rise` (ceiling distances)?
    bool continues_above(LumaView frame, const CornerFit& lower, double wall_angle, double rise) const;

private:
    CameraModel model_;
    LightTable light_;
    EdgeEndSettings settings_;
};

}  // namespace roomfix
