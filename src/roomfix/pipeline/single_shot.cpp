#include "roomfix/pipeline/single_shot.hpp"

#include <fmt/format.h>

#include <map>

#include "roomfix/base/number.hpp"
#include "roomfix/pipeline/corner_camera.hpp"
#include "roomfix/pipeline/tag_camera.hpp"

namespace roomfix {

Fix empty_fix(const std::string& image, const std::string& reason) {
    Fix fix;
    const auto stamp = parse_integer(std::filesystem::path(image).stem().string());
    fix.time = stamp.value_or(0);
    fix.image = image;
    fix.reason = reason;
    return fix;
}

std::vector<RangeObservation> ranges_around(const std::vector<RangeObservation>& ranges, int robot, std::optional<Nanoseconds> time) {
    constexpr double age = 0.5;  // s
    std::map<int, RangeObservation> newest;
    for (const RangeObservation& range : ranges) {
        if (range.robot == robot && (!time || std::abs(to_seconds(range.time - *time)) < age)) newest[range.beacon] = range;
    }
    std::vector<RangeObservation> around;
    for (const auto& [beacon, range] : newest) around.push_back(range);
    return around;
}

Result<Shot> prepare_shot(const Site& site, const SiteCamera& camera, const ShotOptions& options) {
    const bool on_robot = std::holds_alternative<Mount>(camera.placement);
    const bool of_height = std::holds_alternative<KnownHeight>(camera.placement);
    const bool for_corners = looks_for_corners(site, camera) || (on_robot && !options.corner.empty());
    if ((!options.corner.empty() || options.heading) && !(on_robot || of_height)) {
        return Error{fmt::format("--corner and --heading-deg go with a camera that has 'height' or 'mount'; {} is fixed in the map", camera.id)};
    }
    if (!options.landmark.empty() && for_corners) return Error{fmt::format("--landmark does not go with camera {}, which looks for corners", camera.id)};
    if (looks_for_tags(site, camera) && options.corner.empty() && !options.published) return prepare_tag_shot(site, camera, options);
    if (for_corners) return prepare_corner_shot(site, camera, options);
    if (site.robots.empty()) return Error{"the site has no robot: add one under 'robots' with its shape and size"};
    if (on_robot) return prepare_onboard_shot(site, camera, options);
    if (!options.ranges.empty() || !options.landmark.empty()) {
        return Error{fmt::format("--ranges and --landmark go with a camera on a robot; {} is fixed in the map", camera.id)};
    }
    return prepare_fixed_shot(site, camera, options);
}

}  // namespace roomfix
