// Changes single values of a site file in place; comments, order and everything else stay.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"

namespace roomfix {

/// A key of a camera and its new value as YAML on one line; without a value the key goes.
struct CameraValue {
    std::string key;
    std::string value;
};

/// The text of a site file with keys of cameras.CAMERA replaced, added after the others, or removed. An error if there is no such camera.
Result<std::string> with_camera_values(std::string_view text, const std::string& camera, const std::vector<CameraValue>& values);

struct CameraEdit {
    std::string camera;
    std::vector<CameraValue> values;
};

/// Does that to a file, for several cameras. The file as it was is kept beside it, its name followed by the date and time; returns that name.
/// Nothing is changed unless all of it can be written.
Result<std::filesystem::path> write_camera_values(const std::filesystem::path& file, const std::vector<CameraEdit>& edits);

}  // namespace roomfix
