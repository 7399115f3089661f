// A camera fixed in the map: robots by their outlines, their bodies and their tags.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomfix/connect/drawing.hpp"
#include "roomfix/imaging/picture_stabiliser.hpp"
#include "roomfix/overhead/overhead_observer.hpp"
#include "roomfix/overhead/robot_tag.hpp"
#include "roomfix/pipeline/camera/sighting.hpp"

namespace roomfix {

class FixedCamera {
public:
    /// An error if the camera is not fixed in the map, or was not calibrated.
    static Result<FixedCamera> create(const Site& site, const SiteCamera& camera);

    const std::string& id() const { return id_; }
    const View& view() const { return observer_.view(); }
    int robot() const { return -1; }  // none carries it
    void set_background(BackgroundModel background, ColourBackground colour);

    void look(const PictureView& frame, const FrameHints& hints);
    Sighting sighting() const;
    Drawing drawing() const;
    /// So much of the last frame differs from the background that the camera may have been moved.
    bool changed() const { return result_.changed; }
    /// The camera was turned since its background was taken: its pictures are turned back.
    bool moved() const { return stabiliser_.moved(); }
    std::string how_moved() const;

    // Of the last frame, for whoever looks at several cameras together:

    /// The picture that was looked at, as the camera would have taken it where its background was taken: the frame itself, unless the camera was moved.
    LumaView picture() const { return picture_.grey; }
    /// What it shows beside the background; empty without one in colour.
    const Evidence& evidence() const { return observer_.evidence(); }
    const std::vector<SilhouetteObservation>& outlines() const { return result_.observations; }
    bool sees_tag_of(int robot) const;
    /// How much later than the frame's time the middle row of a robot was exposed, s.
    double late(const SilhouetteObservation& seen) const;
    /// The exact outline of a robot that was found by its body.
    std::optional<SilhouetteObservation> outline_at(LumaView frame, const BodySighting& sighting, std::span<const KnownRobot> standing) {
        return observer_.outline_at(frame, sighting, standing);
    }
    void note_exactness(int robot, double nats) { observer_.note_exactness(robot, nats); }
    double own_exactness(int robot) const { return observer_.own_exactness(robot); }
    void set_exactness_to_others(int robot, double nats) { observer_.set_exactness_to_others(robot, nats); }
    /// An outline that was found after the look.
    void add_outline(const SilhouetteObservation& outline);
    /// A robot that was found in several cameras together instead of what this one found by itself.
    void replace_outline(int robot, const SilhouetteObservation* seen);

private:
    FixedCamera(const Site& site, const SiteCamera& camera, const View& view);

    void compare_with_background();
    void choose_reference(const PictureView& frame);
    PoseObservation pose_of(const SilhouetteObservation& seen) const;
    double row_late(double row) const;

    std::string id_;
    double readout_;  // s
    std::vector<SiteRobot> robots_;
    OverheadObserver observer_;
    PictureStabiliser stabiliser_;
    bool beside_background_ = false;       // the stabiliser's reference is the background, not just the first frame
    std::optional<TagDetector> detector_;  // where robots wear tags
    // Of the last frame:
    OverheadResult result_;
    std::vector<PoseObservation> poses_;
    std::vector<TaggedRobot> tagged_;
    PictureView picture_;
};

}  // namespace roomfix
