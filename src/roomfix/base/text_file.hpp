// Whole files as text.
#pragma once

#include <filesystem>
#include <string>

#include "roomfix/base/result.hpp"

namespace roomfix {

/// The text of an empty file is empty. The error names the file.
Result<std::string> read_text(const std::filesystem::path& file);

}  // namespace roomfix
