// Finds robots that are exact solids by their outlines in the foreground of one frame.
#pragma once

#include <memory>
#include <vector>

#include "roomfix/imaging/background_model.hpp"
#include "roomfix/imaging/components.hpp"
#include "roomfix/overhead/body_observer.hpp"
#include "roomfix/overhead/exactness.hpp"
#include "roomfix/overhead/found_outline.hpp"
#include "roomfix/overhead/place_search.hpp"

namespace roomfix {

/// What is known beside the frame.
struct OutlineHints {
    const BodyObserver& bodies;
    const Exactness& exactness;
    const Expectation& expected;         // where robots should be: one fit each, before anything is searched
    const std::vector<char>& elsewhere;  // of each robot: it is not looked for; empty: all are
    bool bodies_too = false;             // robots are found by their whole bodies as well
};

/// Keeps its memory between frames: no allocation in steady state.
class OutlineObserver {
public:
    OutlineObserver(const View& view, std::shared_ptr<const RobotShapes> shapes, const OverheadSettings& settings);

    /// Robots whose outlines explain the foreground; not all of them convince.
    const std::vector<FoundOutline>& find(LumaView frame, const BackgroundModel& background, const OutlineHints& hints);
    /// Of the last frame.
    const std::vector<FoundOutline>& found() const { return found_; }
    const Foreground& foreground() const { return foreground_; }
    const std::vector<Component>& components() const { return finder_.found(); }
    FrameEvidence evidence(LumaView frame, const BackgroundModel& background) const { return {frame, &background, &foreground_, &foreground_.mask, &walls_}; }
    /// That nobody sees through.
    void set_walls(const std::vector<Polyline>& walls) { walls_ = walls; }
    const std::vector<Polyline>& walls() const { return walls_; }

private:
    void find_expected(const FrameEvidence& evidence);
    void weigh_sides(const FrameEvidence& evidence, FoundOutline& found, const PoseObservation* expected) const;
    void find_doubtful(const FrameEvidence& evidence);
    bool is_where_expected(const FoundOutline& found, const PoseObservation& expected) const;
    void explain(const FrameEvidence& evidence, const Component& component);
    FoundOutline best_robot(const FrameEvidence& evidence, const Blob& blob, bool whole);
    FoundOutline best_fit(const FrameEvidence& evidence, const Blob& blob, int robot, bool whole);
    FoundOutline best_area(const FrameEvidence& evidence, const Blob& blob, int robot);
    CoarsePose first_guess(const Blob& blob, const ShapePoints& shape) const;
    Blob look_closer(const FrameEvidence& evidence, const Blob& blob);
    void remove_from_remaining(FoundOutline& found);
    void copy_remaining();
    void keep_one_at_a_place();
    void refit_together(const FrameEvidence& evidence);
    FoundOutline fitted_beside(const FrameEvidence& evidence, const FoundOutline& found, bool only_nearer);
    bool available(int robot) const;
    bool tried_alike(int robot) const;
    std::size_t kind(int robot) const { return hints_->bodies.kind(robot); }

    View view_;
    std::shared_ptr<const RobotShapes> shapes_;
    OverheadSettings settings_;
    std::vector<Polyline> walls_;
    const OutlineHints* hints_ = nullptr;  // during a call
    int searches_left_ = 0;
    std::vector<FoundOutline> found_;
    std::vector<FoundOutline> doubtful_;  // where they are expected, but hardly by their outlines alone
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
    std::vector<Silhouette> others_;
};

}  // namespace roomfix
