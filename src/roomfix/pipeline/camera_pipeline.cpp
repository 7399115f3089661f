#include "roomfix/pipeline/camera_pipeline.hpp"

#include <algorithm>

#include "roomfix/geometry/seen_from_above.hpp"
#include "roomfix/overhead/robot_tag.hpp"

namespace roomfix {

Result<std::unique_ptr<CameraPipeline>> CameraPipeline::create(const Site& site, const SiteCamera& camera) {
    std::unique_ptr<CameraPipeline> pipeline(new CameraPipeline(camera, site.robots));
    const bool tags = looks_for_tags(site, camera);
    if (const auto* height = std::get_if<KnownHeight>(&camera.placement); height && ((site.corners.empty() && !tags) || height->robot.empty())) {
        return std::unique_ptr<CameraPipeline>();
    }
    if (tags) pipeline->tag_camera_ = std::make_unique<TagCamera>(site, camera);
    if (tags && site.corners.empty()) return pipeline;
    if (looks_for_corners(site, camera)) {
        auto corners = CornerCamera::for_camera(site, camera);
        if (!corners) return corners.error();
        pipeline->corners_ = std::move(*corners);
    } else if (std::holds_alternative<Mount>(camera.placement)) {
        auto locator = OnboardLocator::for_camera(site, camera);
        if (!locator) return locator.error();
        pipeline->locator_ = std::move(*locator);
    } else {
        const auto view = fixed_view(camera);
        if (!view) return view.error();
        pipeline->observer_ = std::make_unique<OverheadObserver>(*view, site.robots);
        pipeline->observer_->set_walls(site.walls);
        const bool tagged = std::any_of(site.robots.begin(), site.robots.end(), [](const SiteRobot& r) { return r.tag.has_value(); });
        if (tagged) pipeline->tags_.emplace(site.tag_families());
    }
    return pipeline;
}

int CameraPipeline::robot() const {
    if (locator_) return locator_->robot();
    if (tag_camera_) return tag_camera_->robot();
    return corners_ ? corners_->robot() : -1;
}

double CameraPipeline::look(const PictureView& frame, Nanoseconds time, const FrameHints& hints) {
    const double frozen = frozen_.seconds(frame.grey, time);
    if (frozen > frozen_after) return frozen;
    if (observer_) watch(frame, hints);
    // The ranges of that moment tell like landmarks and like corners apart.
    if (locator_) locator_->locate(&frame.grey, hints.ranges, hints.expected, -1, onboard_);
    if (tag_camera_) tag_camera_->look(frame.grey, by_tags_);
    corner_.located.places.clear();
    if (corners_ && by_tags_.located.places.empty()) {
        CameraHints camera_hints;
        if (hints.expected && hints.expected->yaw_known) {
            camera_hints.prediction = CameraHints::Prediction{hints.expected->pose, hints.expected->covariance};
        }
        camera_hints.ranges = hints.ranges;
        corners_->look(frame.grey, camera_hints, corner_);
    }
    return 0;
}

/// Outlines, and the tags of robots that wear one. A tag says more than an outline.
void CameraPipeline::watch(const PictureView& frame, const FrameHints& hints) {
    observer_->set_elsewhere(hints.elsewhere);
    observer_->set_expected(hints.robots);
    observer_->look_for_bodies(hints.bodies);
    observer_->observe(frame, result_);
    poses_ = poses_of(result_.observations);
    // The tracker knows what is no robot as one more kind of target behind the robots.
    for (const BodyPlace& thing : result_.things) poses_.push_back({static_cast<int>(robots_.size()), thing.pose, false, thing.covariance});
    tagged_.clear();
    if (!tags_) return;
    for (const TaggedRobot& tagged : find_tagged_robots(observer_->view(), robots_, *tags_, frame.grey)) {
        std::erase_if(poses_, [&](const PoseObservation& o) { return o.robot == tagged.robot; });
        TagSighting sighting{tagged.robot, {}, {{tagged.fit.pose, tagged.fit.covariance, true, 1}}};
        for (const Eigen::Vector2d& corner : tagged.corners) sighting.corners.push_back({corner, tagged.sigma * tagged.sigma * Eigen::Matrix2d::Identity()});
        tagged_.push_back(sighting);
    }
}

void CameraPipeline::tell(Tracker& tracker, Nanoseconds time) const {
    if (observer_) tracker.see(time, id(), poses_);
    for (const TagSighting& tag : tagged_) tracker.see(time, id(), tag);
    if (locator_ && !onboard_.located.places.empty()) {
        tracker.see(time, id(), LandmarkSighting{locator_->robot(), onboard_.seen.landmarks, proposals_of(onboard_.located.places)});
    }
    if (!by_tags_.located.places.empty() && by_tags_.located.places[0].weight >= likely) {
        const PoseFromAbove above = seen_from_above(by_tags_.located.places[0].map_from_camera);
        const PoseObservation pose{tag_camera_->robot(), above.pose, above.yaw_known, above.covariance};
        tracker.see(time, id(), {&pose, 1});
    }
    if (!corners_ || corner_.located.places.empty()) return;
    const auto& places = corner_.located.places;
    if (std::holds_alternative<Mount>(camera_.placement)) {
        CornerSighting sighting{corners_->robot(), corner_.seen.corners, {}};
        for (const CameraPlace& p : places) sighting.proposals.push_back({p.pose, p.covariance, p.yaw_known, p.weight});
        tracker.see(time, id(), sighting);
    } else if (corner_.located.best_corner >= likely) {
        // A camera of which only the height is known stands where the robot stands.
        const PoseObservation pose{corners_->robot(), places[0].pose, places[0].yaw_known, places[0].covariance};
        tracker.see(time, id(), {&pose, 1});
    }
}

bool CameraPipeline::sees_tag_of(int robot) const {
    return std::any_of(tagged_.begin(), tagged_.end(), [&](const TagSighting& t) { return t.robot == robot; });
}

void CameraPipeline::replace_outline(int robot, const SilhouetteObservation* seen) {
    std::erase_if(poses_, [&](const PoseObservation& o) { return o.robot == robot; });
    std::erase_if(result_.observations, [&](const SilhouetteObservation& o) { return o.robot == robot; });
    if (seen) result_.observations.push_back(*seen);
}

void CameraPipeline::add_outline(const SilhouetteObservation& outline) {
    result_.observations.push_back(outline);
    poses_.push_back(poses_of({outline}).front());
}

const std::string& CameraPipeline::reason() const {
    if (observer_) return result_.reason;
    if (corners_) return corner_.located.reason;
    return tag_camera_ ? by_tags_.located.reason : onboard_.located.reason;
}

}  // namespace roomfix
