// Mesh files as triangles.
#pragma once

#include <filesystem>
#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/geometry/triangle_mesh.hpp"

namespace roomfix {

/// COLLADA files state which axis is up. In a URDF that is ignored, as RViz and Gazebo do; in a mesh alone it counts.
enum class UpAxis { as_stated, ignored };

/// Is it one of .stl, .obj, .dae, .ply, .gltf, .glb, in capitals or not?
bool is_mesh_file(const std::filesystem::path& file);

/// The triangles of a mesh file, z up; polygons are cut up, points and lines left out. In the file's unit, or in metres where
/// the format states one (glTF and COLLADA do). glTF's y axis is up and becomes z. An error names the file and says what to do.
Result<TriangleMesh> read_mesh(const std::filesystem::path& file, UpAxis up);

/// The same from a file's bytes; its name tells the format, and other files that it needs are looked for beside it.
Result<TriangleMesh> parse_mesh(const std::string& bytes, const std::filesystem::path& file, UpAxis up);

/// A file of at most 200 MB; the error names it.
Result<std::string> read_model_file(const std::filesystem::path& file);

}  // namespace roomfix
