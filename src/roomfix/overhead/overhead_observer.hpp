// A fixed camera watches robots: from a frame to poses on the floor with their covariance.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/imaging/background_model.hpp"
#include "roomfix/imaging/colour_background.hpp"
#include "roomfix/observation/silhouette_observation.hpp"
#include "roomfix/overhead/body_observer.hpp"
#include "roomfix/overhead/body_outlines.hpp"
#include "roomfix/overhead/exactness.hpp"
#include "roomfix/overhead/outline_observer.hpp"

namespace roomfix {

/// What one frame shows.
struct OverheadResult {
    std::vector<SilhouetteObservation> observations;
    std::vector<BodyPlace> things;           // what stands there and is no robot of the site
    std::vector<AbsenceObservation> absent;  // robots that are not where they are expected
    std::string reason;                      // why there is none; empty otherwise
    bool changed = false;                    // so much differs from the background that this is hardly the view it was learned from
};

/// Keeps the background of one camera. Without a background given it learns from the frames it sees, better with time.
class OverheadObserver {
public:
    /// `view` with its covariance; frames must have its size.
    OverheadObserver(const View& view, const std::vector<SiteRobot>& robots, const OverheadSettings& settings = {});

    /// Uses a learned background from now on. Robots are found by their whole body, too, where there is one in colour.
    void set_background(BackgroundModel background, ColourBackground colour = {});
    bool has_background() const { return !background_.empty(); }
    /// The background is still learned from the frames seen, and will change.
    bool learns_background() const { return learning_; }
    const BackgroundModel& background() const { return background_; }
    ColourImage background_picture() const { return colour_background_.picture(); }

    /// Where they stand between the camera and the floor, it sees no robot.
    void set_walls(const std::vector<Polyline>& walls) { outlines_.set_walls(walls); }

    /// Robots (one flag each) that are surely somewhere else and are not looked for; empty: none.
    void set_elsewhere(const std::vector<char>& elsewhere) { elsewhere_ = elsewhere; }

    /// Where robots are expected in the next frame: they are looked for there first, and everywhere only now and then.
    void set_expected(const Expectation& expected) { expected_ = expected; }

    /// False: the whole body is left to somebody who looks at several cameras together; only outlines are observations.
    void look_for_bodies(bool look) { bodies_wanted_ = look; }

    /// Finds the robots in a frame and then refreshes the background where no robot is. `frame` must have the view's size.
    /// No allocation in steady state, as long as `result` is reused.
    void observe(const PictureView& frame, OverheadResult& result);
    /// Of the last frame: what it shows beside the background; empty without a background in colour.
    const Evidence& evidence() const { return evidence_; }

    /// Of the last frame, which is given again: the outline of a robot that was found by its body; nothing where it has not that exact outline.
    /// `standing`: all robots that were found; nearer ones may hide it.
    std::optional<SilhouetteObservation> outline_at(LumaView frame, const BodySighting& sighting, std::span<const KnownRobot> standing);

    /// Somebody who looks at several cameras together knows more: nats by which a robot is the very solid that is described.
    void note_exactness(int robot, double nats) { exactness_.note(bodies_.kind(robot), nats); }
    /// Nats by which a robot is the very solid that is described: as this camera saw robots of its kind, and as others did.
    double own_exactness(int robot) const { return exactness_.own(bodies_.kind(robot)); }
    void set_exactness_to_others(int robot, double nats) { exactness_.set_to_others(bodies_.kind(robot), nats); }

    const Foreground& foreground() const { return outlines_.foreground(); }
    const View& view() const { return view_; }

private:
    void learn_from(const PictureView& frame);
    void observe_bodies(const PictureView& frame, OverheadResult& result);
    bool is_many(int robot) const { return shapes_->robots[static_cast<std::size_t>(robot)].many; }
    std::string reason_for_nothing() const;
    void refresh_background(LumaView frame);

    View view_;
    std::shared_ptr<const RobotShapes> shapes_;
    OverheadSettings settings_;
    std::vector<char> elsewhere_;
    Expectation expected_;
    BackgroundModel background_;
    BackgroundLearner learner_;
    ColourBackground colour_background_;
    ColourFrames colour_frames_;
    int frames_seen_ = 0;
    bool learning_ = true;
    OutlineObserver outlines_;
    BodyObserver bodies_;
    BodyOutlines body_outlines_;
    Exactness exactness_;
    bool bodies_wanted_ = true;

    // Working memory, kept between frames.
    BitMask scratch_;
    Evidence evidence_;
    std::vector<char> wanted_;
    std::vector<KnownRobot> known_;
};

/// A robot found by its body, as an observation of one camera.
SilhouetteObservation observation_of(const BodySighting& sighting, const Body& body, const View& view);

}  // namespace roomfix
