// Learns a camera's background from pictures or a video.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/imaging/background_model.hpp"
#include "roomfix/imaging/colour_background.hpp"
#include "roomfix/pipeline/site_tracker.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// What a camera sees when no robot is there: grey levels at full resolution, and colours.
struct LearnedBackground {
    BackgroundModel grey;
    ColourBackground colour;
};

/// Looks at all frames of the sources (image files, folders, videos) and learns from up to 64 of them, evenly spread. Robots
/// may pass, as long as each place is free more than half of the time. Frames of another size than the camera's are an error.
Result<LearnedBackground> learn_background(const SiteCamera& camera, const std::vector<std::string>& sources, const std::function<void(double)>& progress = {});

/// Where a camera's background comes from: `given`, or if that is empty what the site says; empty where neither says anything.
std::vector<std::string> background_sources(const Site& site, const SiteCamera& camera, const std::vector<std::string>& given);

/// How far (px) a picture lies beside the camera's background because the camera was moved between them; nothing where it does not, or there is no
/// background that can be read. The picture must have the camera's size.
std::optional<double> offset_from_background(const Site& site, const SiteCamera& camera, LumaView picture);

/// Who is told how learning goes on; both may be empty.
struct BackgroundListener {
    std::function<std::function<void(double)>(const SiteCamera&)> progress;  // called before each camera: what gets its 0..1
    std::function<void(const SiteCamera&)> none;                             // a camera that has no background: it learns it while it watches
};

/// The backgrounds of a tracker's fixed cameras: from `for_all`, or if that is empty from what the site says of each.
Result<void> learn_backgrounds(SiteTracker& tracker, const std::vector<std::string>& for_all, const BackgroundListener& listener = {});

}  // namespace roomfix
