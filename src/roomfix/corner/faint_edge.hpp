// How plainly light steps along a whole edge that starts at a corner, however faint each piece of it is.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "roomfix/corner/edge_contrast.hpp"
#include "roomfix/corner/edge_step.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct FaintEdgeSettings {
    double piece = 16;     // px
    int together = 6;      // pieces whose light must step the same way: shading changes along an edge, but slowly
    double first_gap = 8;  // px left out at the corner
    double border = 8;     // px left out at the picture's border
    double blur = 1.2;     // px, of the edge
    double crease = 1.6;   // px: half the width of a crease
    double saturation =
        40;  // squared standard deviations: of a plainer group of pieces more hardly counts, or the frame of a picture would outweigh a whole edge
    double plain_group = 9;  // squared standard deviations that make a group seen
    ContrastChange change;
};

/// Squared standard deviations of a group of pieces, as they count.
double saturated(double squared, const FaintEdgeSettings& settings);

/// What the light along a half-line says.
struct EdgeEvidence {
    double plain = 0;    // over all groups of pieces: squared contrast over its variance, saturated, summed
    double visible = 0;  // px inside the picture
    double seen = 0;     // px of the groups that stand out
    double first = 1e9;  // px from the corner to the first of these
};

class FaintEdges {
public:
    explicit FaintEdges(const CameraModel& model, const FaintEdgeSettings& settings = {});

    /// `corner` and the unit vector `direction` in the normalised picture; only every `skip`-th row is read, as if it were `softer` times more blurred.
    EdgeEvidence along(LumaView frame, const LightTable& light, const Eigen::Vector2d& corner, const Eigen::Vector2d& direction, EdgeKind kind, int skip = 1,
                       double softer = 1) const;

    struct Peak {
        double turn = 0;  // rad, from the direction asked about
        EdgeEvidence evidence;
    };
    /// The directions within `span` (rad) of `direction` where light steps the plainest, the plainest first, at least two blurs apart at the far end.
    void peaks(LumaView frame, const LightTable& light, const Eigen::Vector2d& corner, const Eigen::Vector2d& direction, EdgeKind kind, double span,
               std::vector<Peak>& found) const;

private:
    CameraModel model_;
    FaintEdgeSettings settings_;
    double focal_;
};

}  // namespace roomfix
