// What Assimp makes of a mesh file. It has to run in a process of its own (site/read_mesh).
#pragma once

#include <filesystem>
#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/geometry/triangle_mesh.hpp"

namespace roomfix {

constexpr std::size_t most_triangles = 1'000'000;  // of a model

/// `ending`: of the format, in small letters, without the dot. As the file has it, but in Assimp's axes: y is up in COLLADA
/// files, unless `collada_up` is false. The error is Assimp's own, or says what is wrong with the triangles.
Result<TriangleMesh> import_mesh(const std::string& bytes, const std::filesystem::path& file, const std::string& ending, bool collada_up);

}  // namespace roomfix
