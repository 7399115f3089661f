#include "roomfix/pipeline/corner_camera.hpp"

namespace roomfix {

bool looks_for_corners(const Site& site, const SiteCamera& camera) {
    if (std::holds_alternative<KnownHeight>(camera.placement)) return true;
    const auto* mount = std::get_if<Mount>(&camera.placement);
    if (!mount || site.corners.empty()) return false;
    // Straight up there are landmarks, ahead there are corners.
    const double rise = mount->robot_from_camera.pose.linear()(2, 2);
    return site.landmarks.empty() || rise < 0.8;
}

Result<std::unique_ptr<CornerCamera>> CornerCamera::for_camera(const Site& site, const SiteCamera& camera) {
    const auto locator = CornerLocator::for_camera(site, camera);
    if (!locator) return locator.error();
    return std::unique_ptr<CornerCamera>(new CornerCamera(site, camera, *locator));
}

CornerSettings CornerCamera::settings_for(const SiteCamera& camera) {
    CornerSettings settings;
    settings.by_intrinsics = !camera.intrinsics_covariance.isZero(0);
    return settings;
}

void CornerCamera::look(LumaView frame, const CameraHints& hints, CornerCameraResult& result) {
    observer_.observe(frame, locator_.expected(hints), result.seen);
    locator_.locate(result.seen.corners, hints, result.located);
    if (result.located.places.empty() && result.located.reason.empty()) result.located.reason = result.seen.reason;
}

std::string CornerCamera::corner_name(const CornerCameraResult& result) const {
    return result.located.places.empty() ? std::string() : site_.corners[static_cast<std::size_t>(result.located.places[0].corner)].id;
}

Fix CornerCamera::fix_of(const CornerCameraResult& result, Nanoseconds time, const std::vector<std::string>& sources) const {
    Fix fix;
    fix.time = time;
    if (result.located.places.empty()) {
        fix.reason = result.located.reason;
        return fix;
    }
    const CameraPlace& best = result.located.places[0];
    if (robot() >= 0) fix.robot = site_.robots[static_cast<std::size_t>(robot())].id;
    fix.status = FixStatus::ok;
    fix.pose = best.pose;
    fix.yaw_known = best.yaw_known;
    fix.covariance = best.covariance;
    fix.sources = sources;
    fix.map_from_camera = best.map_from_camera.pose;
    for (const CameraPlace& place : result.located.places) fix.hypotheses.push_back({place.pose, place.weight});
    return fix;
}

}  // namespace roomfix
