// Where the meshes of a URDF are.
#pragma once

#include <filesystem>
#include <string>

#include "roomfix/base/result.hpp"

namespace roomfix {

/// The file that a mesh's `filename` in a URDF means: a path beside the URDF, file:///PATH, or package://NAME/PATH (also model://),
/// which is looked for in all folders above the URDF: as NAME/PATH, and as PATH where the folder itself is called NAME. The
/// error says what was looked for.
Result<std::filesystem::path> urdf_mesh_file(const std::string& filename, const std::filesystem::path& urdf);

}  // namespace roomfix
