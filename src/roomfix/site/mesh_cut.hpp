// Cutting a model by planes so that the convex hulls of its pieces hold less air.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "roomfix/geometry/triangle_mesh.hpp"

namespace roomfix {

/// What some planes across the axes leave of a solid: its surface between them, without caps where it was cut. The hull of the solid
/// needs no caps but those corners of the box of planes that lie inside.
struct Chunk {
    std::shared_ptr<const TriangleMesh> whole;  // the solid before any cut
    TriangleMesh surface;
    std::vector<Eigen::Vector3d> inner;  // corners of `limits` inside the solid
    Eigen::AlignedBox3d limits{Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity()),
                               Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity())};

    bool uncut() const { return !limits.min().array().isFinite().any() && !limits.max().array().isFinite().any(); }
};

Chunk chunk_of(TriangleMesh mesh);

/// A plane across one axis.
struct Cut {
    int axis = 0;       // 0, 1, 2: x, y, z
    double place = 0;   // m along it
    double saving = 0;  // m^3 by which the two hulls are smaller than the one; 0: no cut is any good
};

/// Volume of the chunk's convex hull (m^3), a little too small where it is round.
double hull_volume(const Chunk& chunk);

/// The best of fifteen places along each axis, on faces of the model where there are some.
Cut best_cut(const Chunk& chunk);

/// What lies below and above. Triangles across the plane are cut; one in the plane itself goes where its solid is.
std::pair<Chunk, Chunk> cut_apart(const Chunk& chunk, const Cut& cut);

}  // namespace roomfix
