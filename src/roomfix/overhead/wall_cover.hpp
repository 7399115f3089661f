// What the walls of a site hide of a body from a camera.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomfix/base/fixed_list.hpp"
#include "roomfix/geometry/view.hpp"
#include "roomfix/overhead/body.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// Walls reach the ceiling: they hide upright stretches of the picture, each between the images of two upright lines.
struct WallCover {
    /// The column of an upright line in each row, px of the small picture.
    struct Line {
        double start = 0;
        double per_row = 0;

        double at(int row) const { return start + per_row * row; }
    };
    struct Stretch {
        Line from, to;
    };
    FixedList<Stretch, 6> stretches;
    bool whole = false;  // nothing of the body can be seen

    bool none() const { return !whole && stretches.empty(); }
};

/// What lies between the camera and a body with its middle at `place` (m, map). A wall within 0.3 m of the camera is the one on which it hangs. `scale`: the
/// small picture is so many times smaller than the camera's.
WallCover wall_cover(const View& view, std::span<const Polyline> walls, const Eigen::Vector2d& place, double radius, double height, int scale);

/// Does no wall reach between the camera and any part of a circle around a place (m, map)?
bool in_plain_view(const View& view, std::span<const Polyline> walls, const Eigen::Vector2d& place, double radius);

/// Does a wall stand between the camera and a place (m, map), or end beside the line of sight? `beside`: rad; what is seen there may be the wall's edge.
bool behind_wall(const View& view, std::span<const Polyline> walls, const Eigen::Vector2d& place, double beside);

/// Leaves of a mask what is not hidden.
void take_away(const WallCover& hidden, BodyMask& mask);

}  // namespace roomfix
