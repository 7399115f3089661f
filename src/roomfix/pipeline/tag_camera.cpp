#include "roomfix/pipeline/tag_camera.hpp"

#include <algorithm>

#include "roomfix/geometry/seen_from_above.hpp"
#include "roomfix/imaging/tag_refiner.hpp"

namespace roomfix {

bool looks_for_tags(const Site& site, const SiteCamera& camera) {
    const auto is_tag = [](const SiteLandmark& l) { return std::holds_alternative<Tag>(l.kind); };
    return std::holds_alternative<KnownHeight>(camera.placement) && std::any_of(site.landmarks.begin(), site.landmarks.end(), is_tag);
}

TagCamera::TagCamera(const Site& site, const SiteCamera& camera) : site_(site), model_(camera.model), detector_(site.tag_families()), locator_(site, camera) {
    for (const SiteLandmark& landmark : site.landmarks) {
        const auto* tag = std::get_if<Tag>(&landmark.kind);
        if (tag && can_read(tag->family)) printed_.emplace_back(*tag, tag_picture(tag->family, tag->number));
    }
    if (const auto* known = std::get_if<KnownHeight>(&camera.placement)) robot_ = site.robot(known->robot).value_or(-1);
}

void TagCamera::look(LumaView frame, TagCameraResult& result) {
    detector_.detect(frame, result.seen);
    for (SeenTag& seen : result.seen) {
        for (const auto& [tag, picture] : printed_) {
            if (!tag.is(seen.family, seen.number)) continue;
            if (const auto refined = refine_tag(frame, model_, seen, picture)) seen = *refined;
        }
    }
    locator_.locate(result.seen, result.located);
}

std::string TagCamera::name_of_tag(const SeenTag& seen) const {
    for (const SiteLandmark& landmark : site_.landmarks) {
        const auto* tag = std::get_if<Tag>(&landmark.kind);
        if (tag && tag->is(seen.family, seen.number)) return landmark.id;
    }
    return {};
}

Fix TagCamera::fix_of(const TagCameraResult& result, Nanoseconds time, const std::vector<std::string>& sources) const {
    Fix fix;
    fix.time = time;
    if (result.located.places.empty()) {
        fix.reason = result.located.reason;
        return fix;
    }
    const UncertainPose3& best = result.located.places[0].map_from_camera;
    const PoseFromAbove above = seen_from_above(best);
    if (robot_ >= 0) fix.robot = site_.robots[static_cast<std::size_t>(robot_)].id;
    fix.status = FixStatus::ok;
    fix.pose = above.pose;
    fix.yaw_known = above.yaw_known;
    fix.covariance = above.covariance;
    fix.sources = sources;
    fix.map_from_camera = best.pose;
    for (const TagCameraPlace& place : result.located.places) fix.hypotheses.push_back({seen_from_above(place.map_from_camera).pose, place.weight});
    return fix;
}

}  // namespace roomfix
