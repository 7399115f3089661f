// A site's cameras and its tracker behind one door: pictures, ranges, sightings and odometry in, fixes out.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "roomfix/connect/odometry_source.hpp"
#include "roomfix/connect/sighting_source.hpp"
#include "roomfix/imaging/background_model.hpp"
#include "roomfix/imaging/colour_background.hpp"
#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/observation/time_error.hpp"
#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/pipeline/pace.hpp"
#include "roomfix/pipeline/stage_times.hpp"
#include "roomfix/ranging/range_reader.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

class CameraPipeline;
class Tracker;
class WorkerPool;
struct ShownFrame;
struct TrackerCounts;

/// What is known about one camera, for the page and the final report.
struct CameraState {
    std::string id;
    std::string status = "waiting";  // waiting, ok, slow, changed, moved, frozen, quarantined, away, ended, failed
    std::string message;
    std::string note;  // what a live camera says of itself: where its times come from, what it sets by itself
    long frames = 0;
    long bad_frames = 0;
    long dropped = 0;  // that came but were not looked at, since there was no time
    double rate = 0;   // frames per second
    double busy = 0;   // s per frame spent on it, smoothed
};

/// A frame and the camera that it is of, by its place in the tracker.
struct CameraFrame {
    std::size_t camera = 0;
    PictureView image;
    Nanoseconds time = 0;
    TimeError time_error;
};

/// Who hears what robots sensed.
struct SenseTap {
    std::function<void(const RangeBatch&)> ranges;
    std::function<void(const SightingBatch&)> sightings;
    std::function<void(const OdometryBatch&)> odometry;
};

/// Everything that a page shows beside the fixes, at one moment.
struct SiteSnapshot {
    std::vector<CameraState> cameras;
    std::vector<std::shared_ptr<const ShownFrame>> frames;  // what each camera saw last; null before its first frame
    std::vector<RangeObservation> ranges;                   // the newest of each robot
};

/// May be fed from several threads; a camera's frames from one at a time. Times of all that goes in are of one clock.
class SiteTracker {
public:
    /// An error if the site has no robot, or nothing that could find one: no fixed camera, no camera on a robot, no receiver.
    static Result<std::unique_ptr<SiteTracker>> create(const Site& site);
    ~SiteTracker();
    SiteTracker(const SiteTracker&) = delete;
    SiteTracker& operator=(const SiteTracker&) = delete;

    const Site& site() const;
    /// Cameras that find robots: some of the site's, in its order.
    std::size_t cameras() const;
    const SiteCamera& camera(std::size_t index) const;
    const CameraPipeline& pipeline(std::size_t index) const;
    /// True for a camera that watches from a fixed place and compares with a background.
    bool is_fixed(std::size_t index) const;
    /// Without one, a fixed camera learns it while it watches.
    void set_background(std::size_t index, BackgroundModel background, ColourBackground colour = {});

    /// `listener` gets the fixes that each input makes due, in order, one batch at a time, from the thread that put the input in. No lock is held
    /// that another input needs, so it may take its time, and it may ask the tracker.
    void on_fixes(std::function<void(const FixBatch&)> listener);
    /// `listener` hears of a camera each time when its status changes. It must not ask the tracker.
    void on_camera_status(std::function<void(const CameraState&)> listener);
    /// `listener` hears, as a sentence, of lines of range, sighting and odometry sources that could not be used: of some at once, of the others how many they
    /// were. It must not ask the tracker.
    void on_line_problem(std::function<void(const std::string&)> listener);
    /// Called before each frame is told to the tracker, with the frame's time: what was sensed before it may still be processed then.
    void before_frames(std::function<void(Nanoseconds)> sensed);

    /// One frame of one camera. Errors (wrong size) are counted and reported.
    Result<void> process(const CameraFrame& frame);
    /// Frames of different cameras of about the same time, in the order of their times, looked at side by side. What is known before is
    /// the same for all, and they are told in their order: the fixes do not depend on the number of threads. The first error is returned
    /// after all other frames have been used.
    Result<void> process(const std::vector<CameraFrame>& frames, WorkerPool& pool);
    /// Ranges that receivers heard.
    void process(const RangeBatch& batch);
    /// What robots' detectors saw.
    void process(const SightingBatch& batch);
    /// What robots' wheels reported.
    void process(const OdometryBatch& batch);
    /// `tap` gets everything that is sensed before it is used, from the thread that put it in; no lock is held.
    void tap_senses(SenseTap tap);
    /// Recordings may have gaps of any length: what comes next is of this time.
    void go_on(Nanoseconds time);

    /// Every robot that anything was said of, at that time; also one that was lost since. m, rad, map frame.
    std::vector<Fix> fixes(Nanoseconds time) const;

    /// From now on fixes state how late they are.
    void measure_latency(const Pace& pace);
    bool measures_latency() const;
    /// From now on each camera's last frame and what was seen in it are kept to be shown.
    void keep_frames();
    SiteSnapshot snapshot(Nanoseconds time) const;
    std::shared_ptr<const ShownFrame> shown_frame(const std::string& camera) const;

    void set_camera_state(std::size_t index, const std::string& status, const std::string& message);
    /// What a live camera says of itself.
    void note_source(std::size_t index, const std::string& note);
    /// Says so where this machine is too slow for a camera.
    void count_dropped(std::size_t index, long came, long dropped);
    std::vector<CameraState> camera_states() const;

    void add_problems(const std::vector<std::string>& problems);
    /// At the end: what on_line_problem() has not told yet.
    void finish_line_problems();
    /// Robots that are lost at the end, or were never found, each with why.
    std::vector<std::string> robots_not_found() const;
    StageTimes& stage_times();
    const StageTimes& stage_times() const;

    /// Before the first input: everything is kept, to be smoothed.
    void keep_history();
    /// For what is done after the last input.
    const Tracker& tracker() const;
    /// What the tracker could not use.
    TrackerCounts tracker_counts() const;

private:
    struct Impl;
    explicit SiteTracker(const Site& site);

    std::unique_ptr<Impl> impl_;
};

}  // namespace roomfix
