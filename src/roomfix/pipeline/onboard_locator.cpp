#include "roomfix/pipeline/onboard_locator.hpp"

#include <fmt/format.h>

#include <algorithm>

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

std::vector<PlaceProposal> proposals_of(const std::vector<RobotPlace>& places) {
    std::vector<PlaceProposal> proposals;
    for (const RobotPlace& p : places) proposals.push_back({p.pose, p.covariance, p.yaw_known, p.weight});
    return proposals;
}

Result<std::unique_ptr<OnboardLocator>> OnboardLocator::for_camera(const Site& site, const SiteCamera& camera) {
    const auto* mount = std::get_if<Mount>(&camera.placement);
    const auto robot = mount ? site.robot(mount->robot) : std::nullopt;
    if (!robot) return Error{fmt::format("camera {} is on no robot: give it a 'mount'", camera.id)};
    std::unique_ptr<OnboardLocator> made(new OnboardLocator(site, *robot));
    const CameraOnRobot on_robot = camera_on_robot(camera, *mount);
    made->observer_.emplace(on_robot, mount->has_covariance, site.landmarks);
    made->shapes_ = landmark_shapes(site.landmarks);
    const auto is_tag = [](const SiteLandmark& l) { return std::holds_alternative<Tag>(l.kind); };
    if (std::any_of(site.landmarks.begin(), site.landmarks.end(), is_tag)) made->tags_.emplace(site.tag_families());
    made->locator_ = std::make_unique<RobotLocator>(site, *robot, on_robot);
    return made;
}

Result<std::unique_ptr<OnboardLocator>> OnboardLocator::for_ranges(const Site& site, int robot) {
    if (!site.robots[static_cast<std::size_t>(robot)].receiver()) {
        return Error{fmt::format("robot {} has no receiver: give it 'receiver' with its position", site.robots[static_cast<std::size_t>(robot)].id)};
    }
    std::unique_ptr<OnboardLocator> made(new OnboardLocator(site, robot));
    made->locator_ = std::make_unique<RobotLocator>(site, robot, std::nullopt);
    return made;
}

void OnboardLocator::add_tags(LumaView frame, std::vector<LandmarkObservation>& landmarks) {
    tags_->detect(frame, seen_tags_);
    const double variance = tags_->settings().corner_sigma * tags_->settings().corner_sigma;
    for (const SeenTag& tag : seen_tags_) {
        for (std::size_t s = 0; s < shapes_.size(); ++s) {
            const auto* known = std::get_if<Tag>(&shapes_[s].kind);
            if (!known || !known->is(tag.family, tag.number)) continue;
            LandmarkObservation observation;
            for (const auto& corner : tag.corners) observation.points.push_back({corner, variance * Eigen::Matrix2d::Identity()});
            observation.shapes.push_back(static_cast<int>(s));
            landmarks.push_back(observation);
        }
    }
}

void OnboardLocator::locate(const LumaView* frame, std::span<const RangeObservation> ranges, const std::optional<PoseObservation>& expected, int landmark,
                            OnboardResult& result) {
    result.seen.landmarks.clear();
    result.seen.rejected.clear();
    result.seen.reason.clear();
    if (frame && observer_) observer_->observe(*frame, result.seen);
    if (frame && tags_) add_tags(*frame, result.seen.landmarks);
    const Receiver* receiver = site_.robots[static_cast<std::size_t>(robot_)].receiver();
    std::vector<Eigen::Vector2d> places;
    if (result.seen.landmarks.empty() && receiver) places = places_from(site_, *receiver, ranges);
    LocatorHints hints;
    hints.landmark = landmark;
    hints.places = places;
    if (expected) hints.prediction = LocatorHints::Prediction{expected->pose, expected->covariance};
    locator_->locate(result.seen.landmarks, ranges, hints, result.located);
    if (result.located.places.empty() && !result.seen.reason.empty()) result.located.reason = result.seen.reason;
}

std::vector<std::string> OnboardLocator::landmark_names(const OnboardResult& result) const {
    std::vector<std::string> names(result.seen.landmarks.size());
    if (result.located.places.empty()) return names;
    for (const auto& [observation, landmark] : result.located.places[0].landmarks) {
        names[static_cast<std::size_t>(observation)] = site_.landmarks[static_cast<std::size_t>(landmark)].id;
    }
    return names;
}

std::vector<SeenPoint> OnboardLocator::seen_points(const OnboardResult& result) const {
    if (result.located.places.empty()) return {};
    return locator_->seen_points(result.seen.landmarks, result.located.places[0]);
}

Fix OnboardLocator::fix_of(const OnboardResult& result, Nanoseconds time, const std::vector<std::string>& sources) const {
    Fix fix;
    fix.time = time;
    if (result.located.places.empty()) {
        fix.reason = result.located.reason;
        return fix;
    }
    const RobotPlace& best = result.located.places[0];
    fix.robot = site_.robots[static_cast<std::size_t>(robot_)].id;
    fix.status = FixStatus::ok;
    fix.pose = best.pose;
    fix.yaw_known = best.yaw_known;
    fix.covariance = best.covariance;
    fix.sources = sources;
    for (const RobotPlace& place : result.located.places) fix.hypotheses.push_back({place.pose, place.weight});
    return fix;
}

}  // namespace roomfix
