#include "roomfix/pipeline/camera/landmark_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/ceiling/lamps.hpp"
#include "roomfix/geometry/row_time.hpp"
#include "roomfix/ranging/trilateration.hpp"

namespace roomfix {
namespace {

/// Places that the ranges alone allow: starts for the joint fit.
std::vector<Eigen::Vector2d> places_from(const Site& site, const Receiver& receiver, std::span<const RangeObservation> ranges) {
    std::vector<BeaconRange> beacons;
    for (const RangeObservation& r : ranges) beacons.push_back({site.beacons[static_cast<std::size_t>(r.beacon)].position, r.range, r.sigma});
    std::vector<Eigen::Vector2d> places;
    if (beacons.size() < 3) return places;
    const auto found = trilaterate(beacons, {}, receiver.position.z());
    if (!found) return places;
    for (const TrilaterationPlace& place : found->places) places.push_back(place.position);
    return places;
}

}  // namespace

void add_lamps(Drawing& drawing, LumaView frame) {
    if (!drawing.shows_lamps) return;
    for (const LampBox& lamp : find_lamps(frame)) drawing.lamps.push_back({lamp.left, lamp.top, lamp.right, lamp.bottom});
}

Result<LandmarkCamera> LandmarkCamera::create(const Site& site, const SiteCamera& camera) {
    const auto* mount = std::get_if<Mount>(&camera.placement);
    const auto robot = mount ? site.robot(mount->robot) : std::nullopt;
    if (!robot) return Error{fmt::format("camera {} is on no robot: give it a 'mount'", camera.id)};
    return LandmarkCamera(site, camera, *robot, *mount);
}

LandmarkCamera::LandmarkCamera(const Site& site, const SiteCamera& camera, int robot, const Mount& mount)
    : site_(site),
      robot_(robot),
      readout_(camera.capture.readout),
      rows_(camera.model.height),
      observer_(camera_on_robot(camera, mount), mount.has_covariance, site.landmarks),
      shapes_(landmark_shapes(site.landmarks)),
      locator_(site, robot, camera_on_robot(camera, mount)) {
    const auto is_tag = [](const SiteLandmark& l) { return std::holds_alternative<Tag>(l.kind); };
    if (std::any_of(site.landmarks.begin(), site.landmarks.end(), is_tag)) detector_.emplace(site.tag_families());
}

void LandmarkCamera::add_tags(LumaView frame) {
    detector_->detect(frame, seen_tags_);
    const double variance = detector_->settings().corner_sigma * detector_->settings().corner_sigma;
    for (const SeenTag& tag : seen_tags_) {
        for (std::size_t s = 0; s < shapes_.size(); ++s) {
            const auto* known = std::get_if<Tag>(&shapes_[s].kind);
            if (!known || !known->is(tag.family, tag.number)) continue;
            LandmarkObservation observation;
            for (const auto& corner : tag.corners) observation.points.push_back({corner, variance * Eigen::Matrix2d::Identity()});
            observation.shapes.push_back(static_cast<int>(s));
            seen_.landmarks.push_back(observation);
        }
    }
}

void LandmarkCamera::look(const PictureView& frame, const FrameHints& hints) {
    observer_.observe(frame.grey, seen_);
    if (detector_) add_tags(frame.grey);
    const Receiver* receiver = site_.robots[static_cast<std::size_t>(robot_)].receiver();
    std::vector<Eigen::Vector2d> places;
    if (seen_.landmarks.empty() && receiver) places = places_from(site_, *receiver, hints.ranges);
    LocatorHints known;
    known.landmark = hints.landmark;
    known.places = places;
    if (hints.expected) known.prediction = LocatorHints::Prediction{hints.expected->pose, hints.expected->covariance};
    locator_.locate(seen_.landmarks, hints.ranges, known, located_);
    if (located_.places.empty() && !seen_.reason.empty()) located_.reason = seen_.reason;
}

/// How much later than the frame's time its landmarks were exposed, s.
double LandmarkCamera::late() const {
    double rows = 0, points = 0;
    for (const LandmarkObservation& landmark : seen_.landmarks) {
        for (const PointSighting& point : landmark.points) {
            rows += point.pixel.y();
            ++points;
        }
    }
    return points > 0 ? row_time(readout_, rows_, rows / points) : 0;
}

Sighting LandmarkCamera::sighting() const {
    Sighting sighting;
    sighting.reason = located_.reason;
    if (located_.places.empty()) return sighting;
    const RobotPlace& best = located_.places[0];
    SeenRobot& seen = sighting.robots.emplace_back(SeenRobot{robot_, best.pose, best.yaw_known, best.covariance, {}, {}});
    sighting.landmarks.emplace(LandmarkSighting{robot_, seen_.landmarks, {}});
    for (const RobotPlace& place : located_.places) {
        seen.hypotheses.push_back({place.pose, place.weight});
        sighting.landmarks->proposals.push_back({place.pose, place.covariance, place.yaw_known, place.weight, late()});
    }
    return sighting;
}

Drawing LandmarkCamera::drawing() const {
    Drawing drawing;
    drawing.shows_landmarks = drawing.shows_lamps = true;
    for (std::size_t i = 0; i < seen_.landmarks.size(); ++i) {
        DrawnLandmark& landmark = drawing.landmarks.emplace_back();
        landmark.id = name_of(i);
        for (const PointSighting& point : seen_.landmarks[i].points) landmark.points.push_back(point.pixel.cast<float>());
    }
    for (const RejectedSpot& spot : seen_.rejected) drawing.rejected_spots.push_back(spot.pixel);
    drawing.caption = located_.reason;
    if (!located_.places.empty()) {
        const RobotPlace& place = located_.places[0];
        drawing.caption = fmt::format("x {:.3f} m, y {:.3f} m, yaw {:.1f} deg, +- {:.1f} mm", place.pose.x, place.pose.y, degrees(place.pose.yaw),
                                      1e3 * std::sqrt(place.covariance(0, 0) + place.covariance(1, 1)));
    }
    return drawing;
}

/// The landmark by which the best place explains an observation; empty where it explains it by none.
std::string LandmarkCamera::name_of(std::size_t observation) const {
    if (located_.places.empty()) return {};
    for (const auto& [explained, landmark] : located_.places[0].landmarks) {
        if (explained == static_cast<int>(observation)) return site_.landmarks[static_cast<std::size_t>(landmark)].id;
    }
    return {};
}

std::vector<SeenPoint> LandmarkCamera::seen_points() const {
    if (located_.places.empty()) return {};
    return locator_.seen_points(seen_.landmarks, located_.places[0]);
}

}  // namespace roomfix
