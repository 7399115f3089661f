#include "roomfix/pipeline/camera/tag_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/geometry/row_time.hpp"
#include "roomfix/geometry/seen_from_above.hpp"
#include "roomfix/imaging/tag_refiner.hpp"

namespace roomfix {

bool looks_for_tags(const Site& site, const SiteCamera& camera) {
    const auto is_tag = [](const SiteLandmark& l) { return std::holds_alternative<Tag>(l.kind); };
    return std::holds_alternative<KnownHeight>(camera.placement) && std::any_of(site.landmarks.begin(), site.landmarks.end(), is_tag);
}

TagCamera::TagCamera(const Site& site, const SiteCamera& camera, std::optional<CornerCamera> corners)
    : site_(site),
      model_(camera.model),
      readout_(camera.capture.readout),
      detector_(site.tag_families()),
      locator_(site, camera),
      corners_(std::move(corners)) {
    for (const SiteLandmark& landmark : site.landmarks) {
        const auto* tag = std::get_if<Tag>(&landmark.kind);
        if (tag) printed_.emplace_back(*tag, tag_picture(tag->family, tag->number));
    }
    if (const auto* known = std::get_if<KnownHeight>(&camera.placement)) robot_ = site.robot(known->robot).value_or(-1);
}

Result<TagCamera> TagCamera::create(const Site& site, const SiteCamera& camera) {
    for (const TagFamily family : site.tag_families()) {
        if (!can_read(family)) {
            return Error{fmt::format(
                "this roomfix was built without OpenCV's aruco module and cannot read {}: install libopencv-contrib-dev and build it again", name_of(family))};
        }
    }
    std::optional<CornerCamera> corners;
    if (!site.corners.empty()) {
        auto made = CornerCamera::create(site, camera);
        if (!made) return made.error();
        corners.emplace(std::move(*made));
    }
    return TagCamera(site, camera, std::move(corners));
}

/// Tags of the site are laid onto the picture as a whole, so that their corners are known to a few hundredths of a pixel.
void TagCamera::look(const PictureView& frame, const FrameHints& hints) {
    detector_.detect(frame.grey, seen_);
    for (SeenTag& seen : seen_) {
        for (const auto& [tag, picture] : printed_) {
            if (!tag.is(seen.family, seen.number)) continue;
            if (const auto refined = refine_tag(frame.grey, model_, seen, picture)) seen = *refined;
        }
    }
    locator_.locate(seen_, located_);
    if (by_corner()) corners_->look(frame, hints);
}

/// The landmark that a seen tag is; empty: none of the site.
std::string TagCamera::name_of_tag(const SeenTag& seen) const {
    for (const SiteLandmark& landmark : site_.landmarks) {
        const auto* tag = std::get_if<Tag>(&landmark.kind);
        if (tag && tag->is(seen.family, seen.number)) return landmark.id;
    }
    return {};
}

/// How much later than the frame's time the tags of a place were exposed, s.
double TagCamera::late(const TagCameraPlace& place) const {
    double rows = 0;
    for (const int tag : place.tags) {
        for (const Eigen::Vector2d& corner : seen_[static_cast<std::size_t>(tag)].corners) rows += 0.25 * corner.y();
    }
    return place.tags.empty() ? 0 : row_time(readout_, model_.height, rows / static_cast<double>(place.tags.size()));
}

Sighting TagCamera::sighting() const {
    if (by_corner()) return corners_->sighting();
    Sighting sighting;
    sighting.reason = located_.reason;
    if (located_.places.empty()) return sighting;
    const TagCameraPlace& best = located_.places[0];
    const PoseFromAbove above = seen_from_above(best.map_from_camera);
    SeenRobot& seen = sighting.robots.emplace_back(SeenRobot{robot_, above.pose, above.yaw_known, above.covariance, {}, best.map_from_camera.pose});
    for (const TagCameraPlace& place : located_.places) seen.hypotheses.push_back({seen_from_above(place.map_from_camera).pose, place.weight});
    if (best.weight >= likely) {
        sighting.poses.push_back({robot_, above.pose, above.yaw_known, above.covariance});
        sighting.poses.back().late = late(best);
    }
    return sighting;
}

Drawing TagCamera::drawing() const {
    Drawing drawing = by_corner() ? corners_->drawing() : Drawing();
    drawing.shows_landmarks = true;
    drawing.shows_corners = corners_.has_value();
    for (const SeenTag& seen : seen_) {
        DrawnLandmark& tag = drawing.landmarks.emplace_back();
        tag.id = name_of_tag(seen);
        tag.label = fmt::format("{} {}", name_of(seen.family), seen.number);
        for (const Eigen::Vector2d& corner : seen.corners) tag.points.push_back(corner.cast<float>());
    }
    if (by_corner()) return drawing;
    drawing.caption = located_.reason;
    if (!located_.places.empty()) {
        const UncertainPose3& best = located_.places[0].map_from_camera;
        const Eigen::Vector3d& p = best.pose.translation();
        drawing.caption = fmt::format("camera at {:.3f}, {:.3f}, {:.3f} m, +- {:.1f} mm", p.x(), p.y(), p.z(),
                                      1e3 * std::sqrt(best.covariance.topLeftCorner<3, 3>().trace()));
    }
    return drawing;
}

}  // namespace roomfix
