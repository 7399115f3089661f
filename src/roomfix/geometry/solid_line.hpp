// Where a line along an axis runs inside a closed surface.
#pragma once

#include <utility>
#include <vector>

#include "roomfix/geometry/triangle_mesh.hpp"

namespace roomfix {

/// The crossings of the line through `at` (its coordinate along the axis does not matter) with a mesh. A line exactly along an edge
/// may miss it: choose another.
class SolidLine {
public:
    SolidLine(const TriangleMesh& mesh, int axis, const Eigen::Vector3d& at);

    /// Is the place (m along the axis) inside? Solids may overlap, and may be turned inside out. Where the surface is open there: no.
    bool inside(double place) const;

private:
    std::vector<std::pair<double, int>> crossings_;  // m along the axis; 1: the surface faces down the axis there, -1: up
    bool closed_ = true;
};

}  // namespace roomfix
