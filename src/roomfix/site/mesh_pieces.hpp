// The pieces that a model's triangles hang together in.
#pragma once

#include <vector>

#include "roomfix/geometry/triangle_mesh.hpp"

namespace roomfix {

/// The mesh with corners at one place made one; in formats such as STL each triangle has its own. Triangles without area go.
TriangleMesh welded(const TriangleMesh& mesh);

/// Triangles that share corners, and others, apart. Where there are more than `most` pieces, small ones join the piece whose box
/// grows least by it.
std::vector<TriangleMesh> pieces_of(const TriangleMesh& mesh, std::size_t most);

}  // namespace roomfix
