// Is a mesh file there to its end? Assimp takes some truncated files without a word.
#pragma once

#include <string>

#include "roomfix/base/result.hpp"

namespace roomfix {

/// The error says in a few words what is missing. `ending`: of the format, in small letters, without the dot. OBJ files do not
/// say where they end, so that a truncated one has fewer faces; that is not noticed.
Result<void> check_whole(const std::string& bytes, const std::string& ending);

}  // namespace roomfix
