// One look across a predicted outline: where does the floor end?
#pragma once

#include <Eigen/Core>

namespace roomfix {

struct FrameEvidence;

/// What the picture says along a normal of the outline.
struct EdgeReading {
    bool found = false;
    double offset = 0;                // px from the predicted outline, outwards positive
    double sigma = 1;                 // px, from the pixel noise and the edge's contrast
    double contrast = 0;              // size of the step, as a part of the floor's light
    bool shadowed = false;            // the floor beside the edge lies in shadow
    bool into_shadow = false;         // what the edge leads into may be no more than a shadow on the floor
    bool on_background_edge = false;  // the empty room has an edge there too: it may be the border of something in front
    bool inside_foreground = false;   // is there foreground three pixels inside,
    bool outside_foreground = false;  // and three pixels outside?
};

/// Reads frame / background along `normal` (outwards, unit) within `reach` px of `pixel` and finds the nearest edge that has
/// floor, lit or in shadow, on its outer side. In that ratio the floor's own texture is gone: lit floor is 1, a shadow a
/// lower constant, a robot anything. `pixel` must lie at least 3 px inside the image.
EdgeReading read_edge(const FrameEvidence& evidence, const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, int reach);

}  // namespace roomfix
