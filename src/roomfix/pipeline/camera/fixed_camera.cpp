#include "roomfix/pipeline/camera/fixed_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/geometry/row_time.hpp"

namespace roomfix {

FixedCamera::FixedCamera(const Site& site, const SiteCamera& camera, const View& view)
    : id_(camera.id), readout_(camera.capture.readout), robots_(site.robots), observer_(view, site.robots), stabiliser_(view.model) {
    observer_.set_walls(site.walls);
    if (std::any_of(robots_.begin(), robots_.end(), [](const SiteRobot& r) { return r.tag.has_value(); })) detector_.emplace(site.tag_families());
}

Result<FixedCamera> FixedCamera::create(const Site& site, const SiteCamera& camera) {
    const auto view = fixed_view(camera);
    if (!view) return view.error();
    return FixedCamera(site, camera, *view);
}

void FixedCamera::set_background(BackgroundModel background, ColourBackground colour) {
    observer_.set_background(std::move(background), std::move(colour));
    compare_with_background();
}

void FixedCamera::compare_with_background() {
    const ColourImage picture = observer_.background_picture();
    stabiliser_.set_reference({observer_.background().mean(), &picture});
    beside_background_ = true;
}

/// A camera that learns its background while it watches is compared with the first frame until then.
void FixedCamera::choose_reference(const PictureView& frame) {
    if (beside_background_) return;
    if (!stabiliser_.has_reference()) stabiliser_.set_reference(frame);
    if (observer_.has_background() && !observer_.learns_background()) compare_with_background();
}

std::string FixedCamera::how_moved() const {
    return fmt::format(
        "its picture lies {:.1f} pixels beside its background, as if it was turned by {:.2f} deg: pictures are turned back to where the background was taken, "
        "which is right if it was calibrated there; put it back, or calibrate it anew and take a new background",
        stabiliser_.offset(), degrees(stabiliser_.turned()));
}

void FixedCamera::look(const PictureView& frame, const FrameHints& hints) {
    choose_reference(frame);
    picture_ = stabiliser_.steady(frame, hints.time);
    observer_.set_elsewhere(hints.elsewhere);
    observer_.set_expected(hints.robots);
    observer_.look_for_bodies(hints.bodies);
    observer_.observe(picture_, result_);
    poses_.clear();
    for (const SilhouetteObservation& seen : result_.observations) poses_.push_back(pose_of(seen));
    // The tracker knows what is no robot as one more kind of target behind the robots.
    constexpr double half_a_person = 0.85;  // m
    for (const BodyPlace& thing : result_.things) {
        poses_.push_back({static_cast<int>(robots_.size()), thing.pose, false, thing.covariance});
        if (const auto middle = project_map_point(view(), {thing.pose.x, thing.pose.y, half_a_person})) poses_.back().late = row_late(middle->y());
    }
    tagged_.clear();
    if (detector_) tagged_ = find_tagged_robots(view(), robots_, *detector_, picture_.grey);
    // A tag says more than an outline: it names the robot and its front.
    for (const TaggedRobot& tagged : tagged_) std::erase_if(poses_, [&](const PoseObservation& o) { return o.robot == tagged.robot; });
}

Sighting FixedCamera::sighting() const {
    Sighting sighting;
    sighting.sees_all = true;
    sighting.poses = poses_;
    for (const AbsenceObservation& absence : result_.absent) {
        if (!sees_tag_of(absence.robot)) sighting.absent.push_back(absence);
    }
    sighting.reason = result_.reason;
    for (const TaggedRobot& tagged : tagged_) {
        TagSighting& tag = sighting.tags.emplace_back(TagSighting{tagged.robot, {}, {{tagged.fit.pose, tagged.fit.covariance, true, 1}}});
        double row = 0;
        for (const Eigen::Vector2d& corner : tagged.corners) {
            tag.corners.push_back({corner, tagged.sigma * tagged.sigma * Eigen::Matrix2d::Identity()});
            row += 0.25 * corner.y();
        }
        tag.proposals.front().late = row_late(row);
        sighting.robots.push_back({tagged.robot, tagged.fit.pose, true, tagged.fit.covariance, {}, {}});
    }
    for (const SilhouetteObservation& o : result_.observations) {
        if (sees_tag_of(o.robot)) continue;
        sighting.robots.push_back({o.robot, o.pose, o.yaw_known, o.covariance, {o.hypotheses.begin(), o.hypotheses.end()}, {}, o.existence});
    }
    return sighting;
}

Drawing FixedCamera::drawing() const {
    Drawing drawing;
    for (const SilhouetteObservation& o : result_.observations) {
        DrawnOutline& outline = drawing.outlines.emplace_back();
        outline.robot = robots_[static_cast<std::size_t>(o.robot)].id;
        outline.points.assign(o.outline.begin(), o.outline.end());
        outline.support = o.support;
        outline.label = fmt::format("{} ({:.2f}, {:.2f})", outline.robot, o.pose.x, o.pose.y);
        const auto on_floor = [&](double ahead) -> std::optional<Eigen::Vector2f> {  // m before its middle
            const auto pixel = project_map_point(view(), {o.pose.x + ahead * std::cos(o.pose.yaw), o.pose.y + ahead * std::sin(o.pose.yaw), 0});
            if (!pixel) return std::nullopt;
            return pixel->cast<float>();
        };
        outline.foot = on_floor(0);
        if (o.yaw_known) outline.ahead = on_floor(0.4);
    }
    if (drawing.outlines.empty() && tagged_.empty()) drawing.caption = result_.reason;
    for (const TaggedRobot& tagged : tagged_) {
        DrawnLandmark& tag = drawing.landmarks.emplace_back();
        tag.id = robots_[static_cast<std::size_t>(tagged.robot)].id;
        for (const Eigen::Vector2d& corner : tagged.corners) tag.points.push_back(corner.cast<float>());
    }
    return drawing;
}

bool FixedCamera::sees_tag_of(int robot) const {
    return std::any_of(tagged_.begin(), tagged_.end(), [&](const TaggedRobot& t) { return t.robot == robot; });
}

double FixedCamera::row_late(double row) const {
    const int rows = view().model.height;
    return row_time(readout_, rows, std::clamp(row, 0.0, rows - 1.0));
}

double FixedCamera::late(const SilhouetteObservation& seen) const {
    if (seen.outline.empty()) return 0;
    const auto higher = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) { return a.y() < b.y(); };
    const auto [top, bottom] = std::minmax_element(seen.outline.begin(), seen.outline.end(), higher);
    return 0.5 * (row_late(static_cast<double>(top->y())) + row_late(static_cast<double>(bottom->y())));
}

PoseObservation FixedCamera::pose_of(const SilhouetteObservation& seen) const {
    PoseObservation pose = poses_of({seen}).front();
    pose.late = late(seen);
    return pose;
}

void FixedCamera::replace_outline(int robot, const SilhouetteObservation* seen) {
    std::erase_if(poses_, [&](const PoseObservation& o) { return o.robot == robot; });
    std::erase_if(result_.observations, [&](const SilhouetteObservation& o) { return o.robot == robot; });
    if (seen) result_.observations.push_back(*seen);
}

void FixedCamera::add_outline(const SilhouetteObservation& outline) {
    result_.observations.push_back(outline);
    poses_.push_back(pose_of(outline));
}

}  // namespace roomfix
