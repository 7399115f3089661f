// One camera at work: its frames in, what it saw of robots out.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/estimate/tracker.hpp"
#include "roomfix/overhead/overhead_observer.hpp"
#include "roomfix/pipeline/corner_camera.hpp"
#include "roomfix/pipeline/frozen_picture.hpp"
#include "roomfix/pipeline/onboard_locator.hpp"
#include "roomfix/pipeline/tag_camera.hpp"

namespace roomfix {

constexpr double likely = 0.9;  // weight of a place that is believed, and of a corner that is named

/// What is known before a frame is looked at.
struct FrameHints {
    bool bodies = true;                       // of a fixed camera: looks for whole bodies by itself
    Expectation robots;                       // of a fixed camera
    std::vector<char> elsewhere;              // of each robot: 1 if it surely is where a fixed camera does not see it
    std::vector<RangeObservation> ranges;     // of the robot that carries the camera
    std::optional<PoseObservation> expected;  // where that robot should be
};

/// A frame as it is shown, with what was seen in it.
struct ShownFrame {
    LumaImage picture;
    std::vector<SilhouetteObservation> outlines;
    OnboardResult onboard;
    TagCameraResult by_tags;
    CornerCameraResult corner;
};

/// Fixed, with an observer of outlines; on a robot, with a locator of landmarks; or one that looks for tags, and where it sees none for
/// corners.
class CameraPipeline {
public:
    /// Null for a camera that finds no robot. An error if what the site says about it does not fit together.
    static Result<std::unique_ptr<CameraPipeline>> create(const Site& site, const SiteCamera& camera);

    const SiteCamera& camera() const { return camera_; }
    const std::string& id() const { return camera_.id; }
    /// It watches from a fixed place and compares with a background.
    bool is_fixed() const { return observer_ != nullptr; }
    const View& view() const { return observer_->view(); }  // of a fixed one
    /// The robot that carries it; -1: none, or unknown.
    int robot() const;
    void set_background(BackgroundModel background, ColourBackground colour) { observer_->set_background(std::move(background), std::move(colour)); }

    /// Looks at a frame of the right size. Returns the seconds for which this very picture has been coming if it is frozen, 0 otherwise;
    /// what a frozen picture shows is not looked at.
    double look(const PictureView& frame, Nanoseconds time, const FrameHints& hints);
    /// What the last frame showed goes to the tracker.
    void tell(Tracker& tracker, Nanoseconds time) const;
    /// Of the last frame of a fixed camera: what it shows beside the background; empty without one in colour.
    const Evidence& evidence() const { return observer_->evidence(); }
    /// What the last frame of a fixed camera shows.
    const std::vector<SilhouetteObservation>& outlines() const { return result_.observations; }
    bool sees_tag_of(int robot) const;
    /// The exact outline of a robot that was found by its body, in the last frame of a fixed camera.
    std::optional<SilhouetteObservation> outline_at(LumaView frame, const BodySighting& sighting, std::span<const KnownRobot> standing) {
        return observer_->outline_at(frame, sighting, standing);
    }
    void note_exactness(int robot, double nats) { observer_->note_exactness(robot, nats); }
    double own_exactness(int robot) const { return observer_->own_exactness(robot); }
    void set_exactness_to_others(int robot, double nats) { observer_->set_exactness_to_others(robot, nats); }
    /// An outline that was found after the look.
    void add_outline(const SilhouetteObservation& outline);
    /// A robot that was found in several cameras together instead of what this one found by itself.
    void replace_outline(int robot, const SilhouetteObservation* seen);
    /// So much of the last frame differs from the background that the camera may have been moved.
    bool changed() const { return observer_ && result_.changed; }
    /// Why the last frame showed no robot; empty if it did.
    const std::string& reason() const;

    /// The last frame and what was seen in it.
    ShownFrame shown(LumaView frame) const { return {copy_of(frame), result_.observations, onboard_, by_tags_, corner_}; }
    /// What a page draws into a picture of this camera, as fields of the camera's state. May be called while the camera works.
    void add_drawings(const ShownFrame& shown, nlohmann::json& state) const;

private:
    CameraPipeline(const SiteCamera& camera, const std::vector<SiteRobot>& robots) : camera_(camera), robots_(robots) {}
    void watch(const PictureView& frame, const FrameHints& hints);
    nlohmann::json landmark_drawing(const ShownFrame& shown) const;
    nlohmann::json tag_drawing(const ShownFrame& shown) const;
    nlohmann::json corner_drawing(const ShownFrame& shown) const;

    SiteCamera camera_;
    std::vector<SiteRobot> robots_;
    FrozenPicture frozen_;
    std::unique_ptr<OverheadObserver> observer_;
    std::optional<TagDetector> tags_;  // of robots that wear one
    std::unique_ptr<OnboardLocator> locator_;
    std::unique_ptr<TagCamera> tag_camera_;
    std::unique_ptr<CornerCamera> corners_;
    OverheadResult result_;
    std::vector<PoseObservation> poses_;
    std::vector<TagSighting> tagged_;
    OnboardResult onboard_;
    TagCameraResult by_tags_;
    CornerCameraResult corner_;
};

}  // namespace roomfix
