// Changes single values of a site file in place; comments, order and everything else stay.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "roomfix/base/result.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// The text of a site file with the value of cameras.CAMERA.mount replaced. An error if there is no such key.
Result<std::string> with_mount(std::string_view text, const std::string& camera, const Mount& mount);

/// Does that to a file. The file as it was is kept beside it, its name followed by the date and time; returns that name. Nothing is
/// changed unless all of it can be written.
Result<std::filesystem::path> write_mount(const std::filesystem::path& file, const std::string& camera, const Mount& mount);

}  // namespace roomfix
