// Lens grids as CSV files beside a site file.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "roomfix/base/result.hpp"
#include "roomfix/geometry/lens_grid.hpp"

namespace roomfix {

/// Lines column,row,u,v,ideal_u,ideal_v (px) under that heading: every point of a full grid once, row by row. Errors name the line.
Result<LensGrid> parse_lens_grid(std::string_view text);
Result<LensGrid> load_lens_grid(const std::filesystem::path& file);
std::string lens_grid_text(const LensGrid& grid);

}  // namespace roomfix
