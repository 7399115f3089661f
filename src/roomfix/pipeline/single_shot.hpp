// One picture at a time, without tracking: any camera of a site behind one call.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/observation/fix.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct ShotOptions {
    bool published = false;               // the paper's method instead of ours
    std::vector<std::string> images;      // that will be looked at: enough of them are their own background
    std::vector<std::string> background;  // images, folders, videos without robots
    std::string ranges;                   // file of ranges that the same robot heard
    std::string landmark, corner;         // which one is seen, where it is known
    std::optional<double> heading;        // rad: where the camera looks, roughly, seen from above
    std::function<void(const std::string&)> note = [](const std::string&) {};
};

/// A camera ready to make fixes of pictures.
struct Shot {
    CameraModel model;
    std::function<std::vector<Fix>(const std::string& image, const PictureView& frame)> fixes;
    std::function<Result<void>(const std::filesystem::path& file, LumaView frame)> overlay;  // of the last picture
};

/// Chooses by the camera's placement: fixed in the map, on a robot, or of known height. An error where an option does not go with it.
Result<Shot> prepare_shot(const Site& site, const SiteCamera& camera, const ShotOptions& options);

/// A fix that says why there is none; its time is the picture's name, if that is a number.
Fix empty_fix(const std::string& image, const std::string& reason);

}  // namespace roomfix
