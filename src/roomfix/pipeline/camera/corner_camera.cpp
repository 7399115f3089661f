#include "roomfix/pipeline/camera/corner_camera.hpp"

#include <fmt/format.h>

#include <cmath>

#include "roomfix/geometry/row_time.hpp"

namespace roomfix {
namespace {

CornerSettings settings_for(const SiteCamera& camera) {
    CornerSettings settings;
    settings.by_intrinsics = !camera.intrinsics_covariance.isZero(0);
    return settings;
}

}  // namespace

bool looks_for_corners(const Site& site, const SiteCamera& camera) {
    if (std::holds_alternative<KnownHeight>(camera.placement)) return true;
    const auto* mount = std::get_if<Mount>(&camera.placement);
    if (!mount || site.corners.empty()) return false;
    // Straight up there are landmarks, ahead there are corners.
    const double rise = mount->robot_from_camera.pose.linear()(2, 2);
    return site.landmarks.empty() || rise < 0.8;
}

CornerCamera::CornerCamera(const Site& site, const SiteCamera& camera, const CornerLocator& locator)
    : site_(site),
      on_robot_(std::holds_alternative<Mount>(camera.placement)),
      readout_(camera.capture.readout),
      rows_(camera.model.height),
      locator_(locator),
      observer_(camera.model, locator.wall_angles(), settings_for(camera)) {}

Result<CornerCamera> CornerCamera::create(const Site& site, const SiteCamera& camera) {
    const auto locator = CornerLocator::for_camera(site, camera);
    if (!locator) return locator.error();
    return CornerCamera(site, camera, *locator);
}

/// The same hints in the locator's words. They last as long as `hints`.
CameraHints CornerCamera::hints_for(const FrameHints& hints) const {
    CameraHints known;
    known.corner = hints.corner;
    if (hints.heading) known.heading = CameraHints::Heading{*hints.heading, radians(15)};
    if (hints.expected && hints.expected->yaw_known) known.prediction = CameraHints::Prediction{hints.expected->pose, hints.expected->covariance};
    known.ranges = hints.ranges;
    return known;
}

void CornerCamera::look(const PictureView& frame, const FrameHints& hints) {
    const CameraHints known = hints_for(hints);
    observer_.observe(frame.grey, locator_.expected(known), seen_);
    locate(known);
}

void CornerCamera::place(CornerResult seen, const FrameHints& hints) {
    seen_ = std::move(seen);
    locate(hints_for(hints));
}

/// From the corners of the last frame to the camera's place.
void CornerCamera::locate(const CameraHints& hints) {
    locator_.locate(seen_.corners, hints, located_);
    if (located_.places.empty() && located_.reason.empty()) located_.reason = seen_.reason;
}

/// How much later than the frame's time the corner of a place was exposed, s.
double CornerCamera::late(const CameraPlace& place) const {
    return row_time(readout_, rows_, static_cast<double>(seen_.corners[static_cast<std::size_t>(place.observation)].pixel.y()));
}

Sighting CornerCamera::sighting() const {
    Sighting sighting;
    sighting.reason = located_.reason;
    if (located_.places.empty()) return sighting;
    const CameraPlace& best = located_.places[0];
    SeenRobot& seen = sighting.robots.emplace_back(SeenRobot{robot(), best.pose, best.yaw_known, best.covariance, {}, best.map_from_camera.pose});
    for (const CameraPlace& place : located_.places) seen.hypotheses.push_back({place.pose, place.weight});
    if (on_robot_) {
        sighting.corners.emplace(CornerSighting{robot(), seen_.corners, {}});
        for (const CameraPlace& place : located_.places) {
            sighting.corners->proposals.push_back({place.pose, place.covariance, place.yaw_known, place.weight, late(place)});
        }
    } else if (located_.best_corner >= likely) {
        // A camera of which only the height is known stands where the robot stands.
        sighting.poses.push_back({robot(), best.pose, best.yaw_known, best.covariance});
        sighting.poses.back().late = late(best);
    }
    return sighting;
}

Drawing CornerCamera::drawing() const {
    Drawing drawing;
    drawing.shows_corners = true;
    drawing.caption = located_.reason;
    for (const RejectedLine& line : seen_.rejected) drawing.rejected_lines.push_back({line.from, line.to});
    if (seen_.corners.empty()) return drawing;
    const CameraPlace* best = located_.places.empty() ? nullptr : &located_.places[0];
    const CornerObservation& corner = seen_.corners[best ? static_cast<std::size_t>(best->observation) : 0];
    DrawnCorner& drawn = drawing.corner.emplace();
    drawn.pixel = corner.pixel;
    for (std::size_t e = 0; e < corner.edges.size(); ++e) drawn.edges[e] = {corner.edges[e].ends[0], corner.edges[e].ends[1]};
    if (!best) return drawing;
    if (located_.best_corner > likely) drawn.id = site_.corners[static_cast<std::size_t>(best->corner)].id;
    const Eigen::Vector3d& p = best->map_from_camera.pose.translation();
    drawing.caption = fmt::format("camera at {:.3f}, {:.3f}, {:.3f} m, looks to {:.2f} deg, +- {:.1f} mm", p.x(), p.y(), p.z(), degrees(best->pose.yaw),
                                  1e3 * std::sqrt(best->covariance(0, 0) + best->covariance(1, 1)));
    return drawing;
}

}  // namespace roomfix
