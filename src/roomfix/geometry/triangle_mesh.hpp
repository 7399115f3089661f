// Surfaces made of triangles, and the solids that are common enough to have one.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace roomfix {

/// Triangles as indices of corners; counter-clockwise seen from outside where the surface has an outside.
struct TriangleMesh {
    std::vector<Eigen::Vector3d> corners;  // m
    std::vector<std::array<int, 3>> triangles;

    const Eigen::Vector3d& corner(const std::array<int, 3>& triangle, std::size_t i) const { return corners[static_cast<std::size_t>(triangle[i])]; }
};

/// Adds a mesh that stands elsewhere. `pose` may scale and mirror.
void append(TriangleMesh& mesh, const TriangleMesh& other, const Eigen::Affine3d& pose);

/// The box along the axes around all triangles; empty where there are none.
Eigen::AlignedBox3d box_of(const TriangleMesh& mesh);

/// Volume inside a closed surface (m^3); of an open one, a number without meaning.
double enclosed_volume(const TriangleMesh& mesh);

/// Both with their middle at the origin; a cylinder stands upright as a prism of the circle's mean radius.
TriangleMesh box_mesh(const Eigen::Vector3d& size);
TriangleMesh cylinder_mesh(double radius, double height);

/// A ball as an icosahedron whose triangles are cut in four `level` times: 12, 42, 162, 642 corners at distance 1.
TriangleMesh icosphere(int level);

/// A ball of 42 corners with the volume of the round one.
TriangleMesh ball_mesh(double radius);

}  // namespace roomfix
