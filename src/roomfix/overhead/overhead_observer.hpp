// A fixed camera watches robots: from a frame to poses on the floor with their covariance.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomfix/imaging/background_model.hpp"
#include "roomfix/imaging/colour_background.hpp"
#include "roomfix/imaging/components.hpp"
#include "roomfix/observation/pose_observation.hpp"
#include "roomfix/observation/silhouette_observation.hpp"
#include "roomfix/overhead/body_observer.hpp"
#include "roomfix/overhead/outline_fit.hpp"
#include "roomfix/overhead/place_search.hpp"
#include "roomfix/overhead/robot_search.hpp"

namespace roomfix {

/// One camera asks the edges of a body, so that bodies count that hardly differ from what they stand before.
inline BodyObserverSettings bodies_with_edges() {
    BodyObserverSettings settings;
    settings.search.score.floor_coloured = 0.1;
    return settings;
}

struct OverheadSettings {
    BackgroundSettings background;
    OutlineFitSettings fit;
    PlaceSearchSettings search;
    BodyObserverSettings body = bodies_with_edges();
    double surely_exact = 3;        // nats of all that was seen of a kind of robot, for its outlines to be as exact as they state
    double most_exact = 12;         // nats that are remembered of it ...
    double exact_at_once = 2;       // ... and that one outline may tell
    double least_score = 0.40;      // of an outline fit, to be a fix
    double good_score = 0.60;       // above, no other place is tried
    int least_into_shadow = 4;      // samples of the lower edges that lead into what may be a shadow, to look for the robot behind it
    double least_hidden = 0.24;     // part of the outline that must agree where the rest is hidden
    double surely_filled = 0.85;    // part of the silhouette that is foreground, where the outline alone does not convince
    double least_lead = 0.15;       // of a robot's quality before the next robot's, to know which one it is
    double least_visible = 0.25;    // part of the outline in view
    double rough_parts = 0.012;     // m: how far the sides of a body that is described by its parts are off, where it is not exactly so
    double described = 1.5;         // nats by which such a body, found by its area, stands as its outline says, before its edges are looked at
    double described_at_once = 4;   // nats of that which one outline may tell
    double surely_robot = 0.7;      // probability that what was found by its area is the robot, for what its outline says of the description
    int outline_turns = 8;          // in which its outline is tried where nobody knows how it is turned
    double outline_aside = 1.5;     // deviations of the place that the area tells: so far off it is tried, too, where no edges are in reach
    double turn_known = 0.3;        // rad (1 sigma): where it is known
    double least_filled = 0.42;     // part of the silhouette that is foreground, for many soft targets
    double least_in_picture = 0.5;  // part of a soft target's silhouette that must be in the picture
    double least_left = 0.2;        // part of a silhouette that must be unexplained foreground to look for another robot
    double expected_within = 0.5;   // m, 1 sigma: a robot that is expected no better is looked for everywhere
    double expected_gate = 25;      // squared Mahalanobis distance from where it is expected, up to which an outline found there is the robot's
    int most_blobs = 32;
    int most_searches = 1;  // for outlines of which a part is hidden, in a frame
    int most_starts = 6;    // places of a soft target climbed from
};

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
    void set_walls(const std::vector<Polyline>& walls) { walls_ = walls; }

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
    void note_exactness(int robot, double nats);
    /// Nats by which a robot is the very solid that is described: as this camera saw robots of its kind, and as others did.
    double own_exactness(int robot) const { return exact_[bodies_.kind(robot)]; }
    void set_exactness_to_others(int robot, double nats) { exact_to_others_[bodies_.kind(robot)] = nats; }

    const Foreground& foreground() const { return foreground_; }
    const View& view() const { return view_; }

private:
    /// One robot found, before it becomes an observation.
    struct Found {
        int robot = 0;
        CoarsePose coarse;
        OutlineFit fit;
        bool removed = false;  // its pixels are no longer among those to be explained
        bool by_area = false;  // soft target: found by its area, not by its outline
    };
    void learn_from(const PictureView& frame);
    void observe_outlines(LumaView frame);
    void observe_bodies(const PictureView& frame, OverheadResult& result);
    void find_foreground(LumaView frame);
    void find_expected(const FrameEvidence& evidence);
    void explain(const FrameEvidence& evidence, const Component& component);
    Found best_robot(const FrameEvidence& evidence, const Blob& blob, bool whole);
    Found best_fit(const FrameEvidence& evidence, const Blob& blob, int robot, bool whole);
    bool may_stand_behind(const FrameEvidence& evidence, std::span<const ShapePoints> parts, const OutlineFit& fit) const;
    Blob look_closer(LumaView frame, const Blob& blob);
    Found best_area(const FrameEvidence& evidence, const Blob& blob, int robot);
    CoarsePose first_guess(const Blob& blob, const ShapePoints& shape) const;
    void remove_from_remaining(Found& found);
    void copy_remaining();
    static double quality(const Found& found);
    bool is_where_expected(const Found& found, const PoseObservation& expected) const;
    void keep_one_at_a_place();
    void refit_together(const FrameEvidence& evidence);
    bool acceptable(const Found& found) const;
    bool enough_in_view(const OutlineFit& fit) const { return fit.visible >= settings_.least_visible * fit.total; }
    std::optional<OutlineFit> fit_near(const FrameEvidence& evidence, int robot, const BodyPlace& place);
    void set_nearer(const BodySighting& sighting, std::span<const KnownRobot> standing);
    std::optional<SilhouetteObservation> outline_of_parts(const FrameEvidence& evidence, const BodySighting& sighting);
    void try_outlines(const FrameEvidence& evidence, const BodySighting& sighting);
    void fit_parts(const FrameEvidence& evidence, const BodyPlace& place, const Eigen::Vector2d& aside, double yaw);
    double edges_for(LumaView frame, const BodySighting& sighting, std::span<const KnownRobot> standing);
    double likelihood_of_edges() const;
    void note_description(int robot);
    SilhouetteObservation weighed_outlines(const BodySighting& sighting) const;
    bool available(int robot) const;
    bool tried_alike(int robot) const;
    SilhouetteObservation observation_of(const Found& found) const;
    double exactness(int robot) const { return own_exactness(robot) + exact_to_others_[bodies_.kind(robot)]; }
    void note_outline(const SilhouetteObservation& outline);
    bool is_exact(const SilhouetteObservation& outline) const;
    /// Are outlines worth looking for, by what was seen of such robots before?
    bool may_be_exact(int robot) const { return exactness(robot) > -settings_.surely_exact; }
    std::string reason_for_nothing(const std::vector<Component>& components) const;
    void refresh_background(LumaView frame);

    View view_;
    std::vector<SiteRobot> robots_;
    std::vector<char> elsewhere_;
    Expectation expected_;
    std::vector<Polyline> walls_;
    std::vector<ShapePoints> shapes_;              // of each robot, then of things that are no robots
    std::vector<std::vector<ShapePoints>> parts_;  // of each robot: those whose outline may be fitted
    OverheadSettings settings_;
    BackgroundModel background_;
    BackgroundLearner learner_;
    ColourBackground colour_background_;
    ColourFrames colour_frames_;
    BodyObserver bodies_;
    std::vector<double> exact_;            // of each kind of robot: nats by which it is the solid that the site file describes
    std::vector<double> exact_to_others_;  // the same, as other cameras saw it
    std::vector<double> described_;        // of each kind of robot: nats by which its outlines are about as described
    int frames_seen_ = 0;
    bool learning_ = true;
    bool bodies_wanted_ = true;

    // Working memory, kept between frames.
    Foreground foreground_;
    BitMask scratch_;
    ForegroundMasks masks_;  // what is still to be explained: the frame's own masks, or the copies below
    BitMask remaining_;
    BitMask remaining_shadow_;
    BitMask taken_;
    ComponentFinder finder_;
    std::vector<CoarsePose> starts_;
    PlaceSearch place_search_;
    int searches_left_ = 0;
    std::vector<Found> found_;
    std::vector<Found> doubtful_;  // where they are expected, but hardly by their outlines alone
    std::vector<Silhouette> others_;
    std::vector<ShapePoints> rough_;  // the parts of a robot, less exact than described
    std::vector<OutlineFit> turned_;  // its outline at all poses that were tried, the likeliest first
    Evidence evidence_;
    std::vector<char> wanted_;
    std::vector<KnownRobot> known_;
};

/// A robot found by its body, as an observation of one camera.
SilhouetteObservation observation_of(const BodySighting& sighting, const Body& body, const View& view);

}  // namespace roomfix
