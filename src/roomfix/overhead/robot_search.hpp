// Where could a robot stand? Coarse poses from the foreground's area, before the outline is fitted.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/components.hpp"
#include "roomfix/overhead/silhouette.hpp"

namespace roomfix {

/// The foreground of a frame and how much of it may be shadow.
struct ForegroundMasks {
    const BitMask* foreground = nullptr;
    const BitMask* shadow = nullptr;
    const BitMask* taken = nullptr;  // pixels that robots found before explain; null if none was
};

/// A pose with its agreement with the foreground.
struct CoarsePose {
    Pose2 pose;
    Silhouette silhouette;
    RegionCount inside;
    double agreement = -1e9;  // px: what the silhouette explains less what it contradicts
    double missing = 0;       // certain foreground of the blob outside the silhouette, px

    double open_area() const { return inside.area - inside.taken; }
    double missing_part() const { return missing / std::max(inside.area, 1.0); }
    double filled() const { return open_area() > 0 ? inside.foreground / open_area() : 0; }
};

/// The blob that is to be explained: what is left of its certain foreground and its possible shadow, px.
struct Blob {
    Component component;  // box and middle of the whole blob
    double certain = 0;
    double shadow = 0;
};
Blob measure_blob(const ForegroundMasks& masks, const Component& component);

/// How well a robot at `pose` explains the blob.
CoarsePose coarse_agreement(const ForegroundMasks& masks, const View& view, const ShapePoints& shape, const Pose2& pose, const Blob& blob);

/// The floor place whose silhouette has the blob's centroid in its middle; nothing if no ray reaches the floor there.
std::optional<Pose2> place_from_centroid(const View& view, const ShapePoints& shape, const Eigen::Vector2d& centroid);

/// Climbs from `start` to the best agreement nearby, in x, y and yaw.
CoarsePose climb(const ForegroundMasks& masks, const View& view, const ShapePoints& shape, CoarsePose start, const Blob& blob, double first_step);

/// A rectangle of floor along the map's axes, m. Empty: low > high.
struct FloorRectangle {
    Eigen::Vector2d low, high;
    bool empty() const { return low.x() > high.x(); }
};
/// All the floor that the blob can stand on.
FloorRectangle floor_under(const View& view, const ShapePoints& shape, const Blob& blob);

/// The best poses over all the floor that the blob can stand on, best first, at least half a radius apart or differently
/// turned; at most `most`. `found` is reused memory.
void search_floor(const ForegroundMasks& masks, const View& view, const ShapePoints& shape, const Blob& blob, std::size_t most, std::vector<CoarsePose>& found);

}  // namespace roomfix
