// A model's triangles as the few convex parts that a robot's body is made of.
#pragma once

#include <vector>

#include "roomfix/geometry/triangle_mesh.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

constexpr std::size_t most_model_parts = 40;  // of a model: each part costs time wherever the robot is looked for

/// The hulls of all pieces that hang together; pieces that are far from convex are cut by planes across the axes, where that
/// saves the most air, until no cut saves a hundredth of the whole. At most `most_model_parts` parts of 64 points. Within
/// 2 mm where the points suffice, which they do but for large round shapes. Units and frame as of the mesh (m).
std::vector<ConvexPart> mesh_parts(const TriangleMesh& mesh);

}  // namespace roomfix
