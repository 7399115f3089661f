#include "roomfix/pipeline/published_method.hpp"

namespace roomfix {

Result<PublishedFixed> PublishedFixed::create(const View& view, const std::vector<LumaImage>& empty) {
    const auto rectangle = li2014_rectangle_ahead(view);
    if (!rectangle) return Error{"the published method needs a camera that sees the floor ahead of it"};
    auto method = Li2014::set_up(view.model, *rectangle, li2014_aisle_ahead(view));
    if (!method) return method.error();
    method->set_background(empty);
    return PublishedFixed(std::move(*method));
}

Sighting PublishedFixed::look(LumaView frame) {
    Sighting sighting;
    const auto place = method_.locate(frame);
    if (!place) {
        sighting.reason = "the published method found no blob in the difference image";
        return sighting;
    }
    // 9 cm rms; nothing about the heading.
    const Eigen::Matrix3d covariance = Eigen::Vector3d(0.065 * 0.065, 0.065 * 0.065, 3.29).asDiagonal();
    sighting.robots.push_back({0, {place->x(), place->y(), 0}, false, covariance, {}, {}});
    return sighting;
}

PublishedOnboard::PublishedOnboard(const Site& site, const SiteCamera& camera, int robot, int landmark)
    : robot_(robot), method_(site.landmarks[static_cast<std::size_t>(landmark)], std::get<Mount>(camera.placement)) {
    const SiteLandmark& triangle = site.landmarks[static_cast<std::size_t>(landmark)];
    for (std::size_t b = 0; b < site.beacons.size(); ++b) {
        if (site.beacons[b].id == triangle.beacon) beacon_ = static_cast<int>(b);
    }
    const Receiver* receiver = site.robots[static_cast<std::size_t>(robot)].receiver();
    height_ = triangle.map_from_landmark.translation().z() - (receiver ? receiver->position.z() : 0);
}

Result<PublishedOnboard> PublishedOnboard::create(const Site& site, const SiteCamera& camera, int robot, const FrameHints& hints) {
    const int landmark = hints.landmark >= 0 ? hints.landmark : 0;
    if (site.landmarks.empty() || !std::holds_alternative<LedTriangle>(site.landmarks[static_cast<std::size_t>(landmark)].kind)) {
        return Error{"the published method needs a landmark of three LEDs: add one, or choose it by --landmark"};
    }
    return PublishedOnboard(site, camera, robot, landmark);
}

Sighting PublishedOnboard::look(LumaView frame, const FrameHints& hints) {
    std::optional<double> distance;
    for (const RangeObservation& range : hints.ranges) {
        if (range.beacon == beacon_) distance = range.range;
    }
    Sighting sighting;
    const auto found = method_.locate(frame, distance, height_, &sighting.reason);
    if (!found) return sighting;
    // 2.3 cm rms.
    const Eigen::Matrix3d covariance = Eigen::Vector3d(0.016 * 0.016, 0.016 * 0.016, 0.02 * 0.02).asDiagonal();
    sighting.robots.push_back({robot_, found->pose, true, covariance, {}, {}});
    return sighting;
}

CornerResult PublishedCorner::look(LumaView frame) {
    CornerResult result;
    const auto view = method_.locate(frame, &result.reason);
    if (!view) return result;
    CornerObservation seen;
    seen.view = *view;
    seen.covariance = (Vector5d() << 4e-4, 4e-4, 4e-4, 1e-3, 1e-3).finished().asDiagonal();
    result.corners = {seen};
    return result;
}

}  // namespace roomfix
