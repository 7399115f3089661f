// A site at work: frames in, fixes out. Cameras may be fed from threads of their own.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "roomfix/base/worker_pool.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/web_server.hpp"
#include "roomfix/pipeline/camera_post.hpp"
#include "roomfix/pipeline/fix_output.hpp"
#include "roomfix/pipeline/joint_bodies.hpp"
#include "roomfix/pipeline/live_frames.hpp"
#include "roomfix/pipeline/range_ears.hpp"
#include "roomfix/pipeline/recorded_senses.hpp"
#include "roomfix/pipeline/search_turns.hpp"
#include "roomfix/pipeline/site_calibration.hpp"
#include "roomfix/pipeline/stage_times.hpp"
#include "roomfix/site/site.hpp"
#include "roomfix/smooth/smoother.hpp"

namespace roomfix {

/// What is known about one source, for the page and the final report.
struct SourceState {
    std::string id;
    std::string status = "waiting";  // waiting, ok, slow, changed, frozen, quarantined, ended, failed
    std::string message;
    long frames = 0;
    long bad_frames = 0;
    long dropped = 0;  // that came but were not looked at, since there was no time
    double rate = 0;   // frames per second
    double busy = 0;   // s per frame spent on it, smoothed
};

struct RunSettings {
    double speed = 1;      // of recordings, times as fast as they were taken; 0: as fast as it goes
    bool on_time = false;  // keep up with the clock: frames of recordings, too, are dropped where there is no time; fixes state their latency
    int threads = 1;       // that look at recorded frames; the fixes do not depend on it
};

/// A frame and the camera that it is of, by its place in the runner.
struct CameraFrame {
    std::size_t camera = 0;
    PictureView image;
    Nanoseconds time = 0;
};

class SiteRunner {
public:
    /// An error if the site has no robot, or nothing that could find one: no fixed camera, no camera on a robot, no receiver.
    static Result<std::unique_ptr<SiteRunner>> create(const Site& site);

    /// Where fixes go: one line each, flushed at every frame. "-" is stdout.
    Result<void> write_fixes_to(const std::string& file) { return output_.open(file); }
    /// Fixes are kept back, to be smoothed and written by `write_smoothed`; the tracker keeps its history.
    void keep_for_smoothing();
    /// Where smoothing did not settle the tracker's fixes are written.
    std::vector<Unsettled> write_smoothed(const SmootherSettings& settings, const std::function<void(double)>& progress = {});
    /// After keep_for_smoothing() and running: the cameras as the robots' ways through all of them calibrate them.
    std::vector<SiteCalibration> calibrate(const std::function<void(double)>& progress = {}) const;
    /// Serves the page from now on.
    Result<void> serve_page(const std::string& host, int port);
    int page_port() const { return page_ ? page_->port() : 0; }

    std::size_t cameras() const { return stations_.size(); }
    const SiteCamera& camera(std::size_t index) const { return stations_[index]->post->camera(); }
    /// True for a camera that watches from a fixed place and compares with a background.
    bool is_fixed(std::size_t index) const { return stations_[index]->post->is_fixed(); }
    void set_background(std::size_t index, BackgroundModel background, ColourBackground colour = {});

    /// From now on times are those of the system's clock, and fixes state how late they are.
    void measure_latency();
    /// One frame of one camera: observes, tracks, and passes the fixes on. Errors (wrong size) are counted and reported.
    Result<void> feed(const CameraFrame& frame);
    /// Frames of different cameras of about the same time, in the order of their times, looked at side by side. What is known before is
    /// the same for all, and they are told in their order: the fixes do not depend on the number of threads. The first error is returned
    /// after all other frames have been used.
    Result<void> feed(const std::vector<CameraFrame>& frames, WorkerPool& pool);
    /// Ranges that receivers heard.
    void hear(const RangeBatch& batch);
    /// What robots' detectors saw.
    void detect(const SightingBatch& batch);
    /// What robots' wheels reported.
    void drive(const OdometryBatch& batch);

    void set_source_state(std::size_t index, const std::string& status, const std::string& message);
    std::vector<SourceState> source_states() const;

    /// Runs all sources of the site to their end: recorded ones in the order of their times, live ones each in its thread. `stop` ends it
    /// early. `progress` gets 0..1.
    Result<void> run_sources(const RunSettings& settings, const std::atomic<bool>& stop, const std::function<void(double)>& progress = {});
    /// The same with sources of one's own, one for each camera.
    Result<void> run_sources(std::vector<std::unique_ptr<FrameSource>> sources, const RunSettings& settings, const std::atomic<bool>& stop,
                             const std::function<void(double)>& progress = {});
    long fixes_given() const { return output_.given(); }
    /// Lines of range and odometry sources that could not be used, as sentences; at most some of them.
    std::vector<std::string> line_problems() const;
    /// After a recording: what seems to be wrong with the robots' own senses as they were given, as sentences with the cure.
    std::vector<std::string> suspicious_inputs() const;
    /// Robots that are lost at the end, or were never found, each with why.
    std::vector<std::string> robots_not_found() const;
    const StageTimes& stage_times() const { return times_; }
    /// For what is done after the sources have ended.
    const Tracker& tracker() const { return tracker_; }
    /// What the tracker could not use.
    TrackerCounts tracker_counts() const;

private:
    struct Station {
        std::unique_ptr<CameraPost> post;  // used by one thread at a time
        SourceState state;
        double last_wall = 0;  // s, when the last frame came
        SearchTurns turns;
    };
    /// What one frame gave, before it is told.
    struct Look {
        LatencyParts parts;
        double frozen = 0;
    };
    /// Which moment of the clock a time stamp is.
    struct Pace {
        double wall = 0;       // s, steady clock ...
        Nanoseconds time = 0;  // ... and the time stamp of the same moment
        double speed = 1;

        double wall_of(Nanoseconds t) const { return wall + to_seconds(t - time) / speed; }
    };
    explicit SiteRunner(const Site& site);
    Result<void> check_size(const CameraFrame& frame);
    FrameHints hints_for(const CameraPost& post, Nanoseconds time) const;
    int unknown_robot() const { return static_cast<int>(site_.robots.size()); }  // index of the tracker's last kind of target
    std::vector<PoseObservation> expected_things(Nanoseconds time) const;
    PoseObservation observation_of(const BodyPlace& thing) const;
    std::vector<char> robots_elsewhere(const CameraPost& post, Nanoseconds time) const;
    Look look(const CameraFrame& frame, const FrameHints& hints);
    void report(const CameraFrame& frame, const Look& look);
    JointSighting look_together(const std::vector<CameraFrame>& frames, std::vector<std::optional<Look>>& looks, const std::vector<FrameHints>& hints);
    std::optional<double> latency(Nanoseconds time) const;
    Result<void> run_recorded(std::vector<std::unique_ptr<FrameSource>>& sources, const RunSettings& settings, const std::atomic<bool>& stop,
                              const std::function<void(double)>& progress);
    Result<void> feed_round(const std::vector<CameraFrame>& frames, WorkerPool& pool);
    void go_on(Nanoseconds time);
    void run_live(const std::vector<LiveSource>& sources, int threads, const std::atomic<bool>& stop);
    void count_dropped(std::size_t index, const FrameCount& count);
    void note_quarantine(const CameraPost& post, SourceState& state) const;
    void listen(const std::string& device, int robot, int receiver, const std::atomic<bool>& stop);
    void tell_until(Nanoseconds time);
    void add_problems(const std::vector<std::string>& problems);
    void pass_on(Nanoseconds time, const std::string& source, const LatencyParts& parts = {});
    void pass_on(Nanoseconds time, const std::function<bool(const Fix&)>& is_due, const LatencyParts& parts);
    bool wheels_give_fix(int robot, Nanoseconds time) const;
    std::string state_json(Nanoseconds time, const std::vector<Fix>& fixes) const;
    nlohmann::json ranges_json(Nanoseconds time) const;
    std::string site_json() const;
    std::vector<std::uint8_t> picture_of(const std::string& camera);

    Site site_;
    std::vector<std::unique_ptr<Station>> stations_;  // one for each camera that finds robots
    std::mutex joint_mutex_;                          // guards:
    JointBodies joint_bodies_;
    RangeEars ears_;
    RecordedSenses recorded_;
    std::vector<std::string> line_problems_;
    mutable std::mutex mutex_;  // guards the tracker, the sinks, the stations' states and what is shown
    Tracker tracker_;
    std::map<std::string, FixStatus> last_status_;   // of each robot, to say only once that it is lost
    std::map<std::string, Nanoseconds> last_given_;  // when each robot got its last fix
    FixOutput output_;
    bool smoothing_ = false;
    std::vector<Fix> kept_;  // for smoothing
    std::optional<Pace> pace_;
    std::unique_ptr<WebServer> page_;
    double last_published_ = 0;
    StageTimes times_;
};

}  // namespace roomfix
