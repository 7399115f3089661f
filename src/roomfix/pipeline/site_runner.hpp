// A site at work: frames in, fixes out. Cameras may be fed from threads of their own.
#pragma once

#include <atomic>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/odometry_source.hpp"
#include "roomfix/connect/web_server.hpp"
#include "roomfix/estimate/tracker.hpp"
#include "roomfix/overhead/overhead_observer.hpp"
#include "roomfix/pipeline/corner_camera.hpp"
#include "roomfix/pipeline/frozen_picture.hpp"
#include "roomfix/pipeline/onboard_locator.hpp"
#include "roomfix/pipeline/range_ears.hpp"
#include "roomfix/ranging/range_reader.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

constexpr double likely = 0.9;  // weight of a place that is believed, and of a corner that is named

/// What is known about one source, for the page and the final report.
struct SourceState {
    std::string id;
    std::string status = "waiting";  // waiting, ok, slow, ended, failed
    std::string message;
    long frames = 0;
    long bad_frames = 0;
    double rate = 0;  // frames per second
    double busy = 0;  // s per frame spent on it, smoothed
};

class SiteRunner {
public:
    /// An error if the site has no robot, or nothing that could find one: no fixed camera, no camera on a robot, no receiver.
    static Result<std::unique_ptr<SiteRunner>> create(const Site& site);

    /// Where fixes go: one line each, flushed at every frame. "-" is stdout.
    Result<void> write_fixes_to(const std::string& file);
    /// Serves the page from now on.
    Result<void> serve_page(const std::string& host, int port);
    int page_port() const { return page_ ? page_->port() : 0; }

    std::size_t cameras() const { return posts_.size(); }
    const SiteCamera& camera(std::size_t index) const { return posts_[index]->camera; }
    /// True for a camera that watches from a fixed place and compares with a background.
    bool is_fixed(std::size_t index) const { return posts_[index]->observer != nullptr; }
    void set_background(std::size_t index, BackgroundModel background);

    /// One frame of one camera: observes, smooths, and passes the fixes on. Errors (wrong size) are counted and reported.
    Result<void> feed(std::size_t index, LumaView frame, Nanoseconds time);
    /// Ranges that receivers heard.
    void hear(const RangeBatch& batch);
    /// What robots' wheels reported.
    void drive(const OdometryBatch& batch);

    void set_source_state(std::size_t index, const std::string& status, const std::string& message);
    std::vector<SourceState> source_states() const;

    /// Runs all sources of the site to their end: recorded ones in the order of their times, `speed` times as fast as they
    /// were taken (0: as fast as it goes); live ones each in its thread. `stop` ends it early. `progress` gets 0..1.
    Result<void> run_sources(double speed, const std::atomic<bool>& stop, const std::function<void(double)>& progress = {});
    long fixes_given() const { return fixes_given_; }
    /// Lines of range and odometry sources that could not be used, as sentences; at most some of them.
    std::vector<std::string> line_problems() const;
    /// What the tracker could not use.
    TrackerCounts tracker_counts() const;

private:
    /// One camera: fixed, with an observer; on a robot, with a locator; or one that looks for corners.
    struct Post {
        SiteCamera camera;
        std::unique_ptr<OverheadObserver> observer;
        std::optional<TagDetector> tags;  // of robots that carry one
        OverheadResult result;            // the observing thread's own
        std::vector<PoseObservation> poses;
        std::unique_ptr<OnboardLocator> locator;
        OnboardResult onboard;  // the observing thread's own
        std::unique_ptr<CornerCamera> corners;
        CornerCameraResult corner;  // the observing thread's own
        CornerCameraResult shown_corner;
        std::vector<SilhouetteObservation> shown;  // of the last frame, for the page
        OnboardResult shown_onboard;
        LumaImage last;  // for the page
        SourceState state;
        double last_wall = 0;  // s, when the last frame came
        FrozenPicture frozen;
    };
    explicit SiteRunner(const Site& site);
    Result<void> run_recorded(std::vector<std::unique_ptr<FrameSource>>& sources, double speed, const std::atomic<bool>& stop,
                              const std::function<void(double)>& progress);
    void run_live(std::size_t index, FrameSource& source, const std::atomic<bool>& stop);
    void watch(Post& post, LumaView frame, Nanoseconds time);
    std::vector<char> robots_elsewhere(const Post& post, Nanoseconds time) const;
    void look_for_corner(Post& post, LumaView frame, Nanoseconds time);
    void look_up(Post& post, LumaView frame, Nanoseconds time);
    const std::string& reason_of(const Post& post) const;
    void tell_tracker(const Post& post, Nanoseconds time);
    std::optional<std::string> quarantine_of(const Post& post) const;
    Result<void> load_recorded();
    void listen(const std::string& device, int robot, const std::atomic<bool>& stop);
    void tell_until(Nanoseconds time);
    void add_problems(const std::vector<std::string>& problems);
    void pass_on(Nanoseconds time, const std::string& camera);
    std::string state_json(Nanoseconds time, const std::vector<Fix>& fixes) const;
    nlohmann::json ranges_json(Nanoseconds time) const;
    nlohmann::json onboard_json(const Post& post) const;
    nlohmann::json corner_json(const Post& post) const;
    std::string site_json() const;
    std::vector<std::uint8_t> picture_of(const std::string& camera);

    Site site_;
    std::vector<std::unique_ptr<Post>> posts_;
    RangeEars ears_;
    RangeBatch recorded_ranges_;       // in the order of their times
    OdometryBatch recorded_odometry_;  // likewise
    std::size_t next_range_ = 0;       // the first that is still to be told
    std::size_t next_odometry_ = 0;
    std::size_t next_difference_ = 0;
    std::vector<std::string> line_problems_;
    mutable std::mutex mutex_;  // guards the tracker, the sinks and the posts' pictures and states
    Tracker tracker_;
    std::map<std::string, FixStatus> last_status_;  // of each robot, to say only once that it is lost
    std::ofstream fixes_file_;
    bool fixes_to_stdout_ = false;
    std::unique_ptr<WebServer> page_;
    double last_published_ = 0;
    long fixes_given_ = 0;
};

}  // namespace roomfix
