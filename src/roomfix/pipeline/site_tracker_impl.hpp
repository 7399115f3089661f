// What is behind SiteTracker.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/worker_pool.hpp"
#include "roomfix/estimate/tracker.hpp"
#include "roomfix/pipeline/camera_pipeline.hpp"
#include "roomfix/pipeline/fix_delivery.hpp"
#include "roomfix/pipeline/joint_bodies.hpp"
#include "roomfix/pipeline/line_problems.hpp"
#include "roomfix/pipeline/receiver_buffer.hpp"
#include "roomfix/pipeline/search_turns.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

struct SiteTracker::Impl {
    struct Camera {
        std::unique_ptr<CameraPipeline> pipeline;  // used by one thread at a time
        CameraState state;
        std::string told = "ok";  // status that the listener knows
        std::shared_ptr<const ShownFrame> shown;
        double last_wall = 0;  // s, when the last frame came
        SearchTurns turns;
    };
    /// What one frame gave, before it is told.
    struct Look {
        LatencyParts parts;
        double frozen = 0;
    };
    explicit Impl(const Site& site);
    Result<void> add_camera(const SiteCamera& camera);
    const SiteCamera& camera(std::size_t index) const { return cameras_[index]->pipeline->camera(); }
    bool is_fixed(std::size_t index) const { return cameras_[index]->pipeline->fixed() != nullptr; }
    Result<void> process(const std::vector<CameraFrame>& frames, WorkerPool& pool);
    void process(const RangeBatch& batch);
    void process(const SightingBatch& batch);
    void process(const OdometryBatch& batch);
    SiteSnapshot snapshot(Nanoseconds time) const;
    std::shared_ptr<const ShownFrame> shown_frame(const std::string& camera) const;
    void set_camera_state(std::size_t index, const std::string& status, const std::string& message);
    void note_source(std::size_t index, const std::string& note);
    void count_dropped(std::size_t index, long came, long dropped);
    std::vector<CameraState> camera_states() const;
    std::vector<std::string> robots_not_found() const;
    Result<void> process_round(const std::vector<CameraFrame>& frames, WorkerPool& pool);
    Result<void> check_size(const CameraFrame& frame);
    FrameHints hints_for(const CameraPipeline& camera, Nanoseconds time) const;
    int unknown_robot() const { return static_cast<int>(site_.robots.size()); }  // index of the tracker's last kind of target
    std::vector<PoseObservation> expected_things(Nanoseconds time) const;
    PoseObservation observation_of(const BodyPlace& thing) const;
    std::vector<char> robots_elsewhere(const View& view, Nanoseconds time) const;
    Look look(const CameraFrame& frame, const FrameHints& hints);
    JointSighting look_together(const std::vector<CameraFrame>& frames, std::vector<std::optional<Look>>& looks, const std::vector<FrameHints>& hints);
    void report(const CameraFrame& frame, const Look& look);
    void tell_status(Camera& camera);
    void note_quarantine(const CameraPipeline& camera, CameraState& state) const;
    bool wheels_give_fix(int robot, Nanoseconds time) const;
    void make_due(Nanoseconds time, const std::string& source, const LatencyParts& parts = {});

    Site site_;
    std::vector<std::unique_ptr<Camera>> cameras_;
    std::function<void(Nanoseconds)> sensed_until_;
    SenseTap tap_;
    std::function<void(const CameraState&)> status_listener_;
    bool keeps_frames_ = false;
    StageTimes times_;
    FixDelivery delivery_{times_};
    std::mutex joint_mutex_;  // guards:
    JointBodies joint_bodies_;
    mutable std::mutex mutex_;  // guards all below, and the cameras' states and shown frames
    ReceiverBuffer receivers_;
    Tracker tracker_;
    Nanoseconds last_report_ = never;  // of any wheels
    Nanoseconds last_word_ = never;    // when the last frame, range or sighting came, by the time of what else had come
    LineProblems line_problems_;
};

}  // namespace roomfix
