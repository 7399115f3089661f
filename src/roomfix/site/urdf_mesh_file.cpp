#include "roomfix/site/urdf_mesh_file.hpp"

#include <fmt/format.h>

namespace roomfix {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
    std::error_code failure;
    return fs::is_regular_file(path, failure);
}

Result<fs::path> in_package(const fs::path& path, const fs::path& urdf) {
    std::error_code failure;
    const fs::path name = *path.begin();
    const fs::path inside = path.lexically_relative(name);
    const fs::path start = fs::absolute(urdf, failure).lexically_normal().parent_path();
    for (fs::path folder = start;; folder = folder.parent_path()) {
        if (folder.filename() == name && is_file(folder / inside)) return folder / inside;
        if (is_file(folder / path)) return folder / path;
        if (folder == folder.parent_path()) break;
    }
    return Error{fmt::format("the mesh '{}' of the package '{}' is in no folder above the URDF ({} and so on up): put the package's folder there",
                             inside.string(), name.string(), (start / path).string())};
}

}  // namespace

Result<fs::path> urdf_mesh_file(const std::string& filename, const fs::path& urdf) {
    for (const std::string scheme : {"package://", "model://"}) {
        if (!filename.starts_with(scheme)) continue;
        const fs::path path = fs::path(filename.substr(scheme.size())).lexically_normal();
        if (path.empty() || path.is_absolute() || *path.begin() == "..") return Error{fmt::format("'{}' names no package", filename)};
        return in_package(path, urdf);
    }
    const bool absolute = filename.starts_with("file://");
    if (!absolute && filename.find("://") != std::string::npos)
        return Error{fmt::format("'{}' is no file on this computer: copy it beside the URDF", filename)};
    const fs::path path = absolute ? fs::path(filename.substr(7)) : urdf.parent_path() / filename;
    if (filename.empty() || !is_file(path)) return Error{fmt::format("there is no mesh {}: copy it there, or correct the name", path.string())};
    return path;
}

}  // namespace roomfix
