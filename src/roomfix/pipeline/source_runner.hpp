// A site's sources at work: recorded and live ones, at their pace, into a tracker, and its fixes to sinks.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "roomfix/connect/frame_source.hpp"
#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/pipeline/site_tracker.hpp"
#include "roomfix/pipeline/zone_watch.hpp"

namespace roomfix {

class LiveSenses;
class RecordedSenses;
class SessionRecorder;
class SinkQueue;
struct SenseState;
struct LiveSource;

struct RunSettings {
    double speed = 1;      // of recordings, times as fast as they were taken; 0: as fast as it goes
    bool on_time = false;  // keep up with the clock: frames of recordings, too, are dropped where there is no time; fixes state their latency
    int threads = 1;       // that look at recorded frames; the fixes do not depend on it
};

class SourceRunner {
public:
    /// `tracker` must outlive it, and gets nothing more once the runner is gone.
    explicit SourceRunner(SiteTracker& tracker);
    ~SourceRunner();
    SourceRunner(const SourceRunner&) = delete;
    SourceRunner& operator=(const SourceRunner&) = delete;

    /// Before the run: the sink gets all its fixes. `overflow`: what happens where it cannot keep up.
    void add_sink(std::unique_ptr<FixSink> sink, Overflow overflow, std::size_t capacity = 1000);
    /// From now on everything that the tracker gets and gives is recorded. Before `run`; `recorder` must outlive the runner.
    void record_to(SessionRecorder& recorder);
    /// Waits until every sink has what it was given. The first error of any of them.
    Result<void> finish_sinks();
    /// Of all sinks, and of the recording. From any thread.
    std::vector<SinkState> sink_states() const;
    /// Of senses whose readings come as they come, while it runs. From any thread.
    std::vector<SenseState> sense_states() const;

    /// Zones that replace those of the site from now on. From any thread.
    void set_zones(std::vector<SiteZone> zones);
    /// The zones now, and how often they were replaced.
    std::pair<std::vector<SiteZone>, int> zones() const;
    /// The last ones, at most 50, the newest last. From any thread.
    std::vector<ZoneEvent> zone_events() const;

    /// Runs all sources of the site to their end: recorded ones in the order of their times, live ones each in its thread. `stop` ends it
    /// early. `progress` gets 0..1.
    Result<void> run(const RunSettings& settings, const std::atomic<bool>& stop, const std::function<void(double)>& progress = {});
    /// The same with sources of one's own, one for each camera of the tracker.
    Result<void> run(std::vector<std::unique_ptr<FrameSource>> sources, const RunSettings& settings, const std::atomic<bool>& stop,
                     const std::function<void(double)>& progress = {});
    /// After a recording: what seems to be wrong with the robots' own senses as they were given, as sentences with the cure.
    std::vector<std::string> suspicious_inputs() const;

private:
    Result<void> load_senses();
    Result<void> run_recorded(std::vector<std::unique_ptr<FrameSource>>& sources, const RunSettings& settings, const std::atomic<bool>& stop,
                              const std::function<void(double)>& progress);
    void run_live(const std::vector<LiveSource>& sources, int threads, const std::atomic<bool>& stop);
    void process_senses_until(Nanoseconds time);
    void tell_time(Nanoseconds now);
    void tell_of_silence(const std::atomic<bool>& stop);
    void give(FixBatch batch);

    SiteTracker& tracker_;
    SessionRecorder* recorder_ = nullptr;
    std::atomic<double> last_batch_{0};  // s, steady: when sinks last got something
    std::mutex senses_mutex_;            // held while recorded readings are told: live cameras and recordings may ask for them at once
    std::unique_ptr<RecordedSenses> recorded_;
    mutable std::mutex zones_mutex_;  // guards:
    ZoneWatch zones_;
    int zones_version_ = 0;
    Nanoseconds last_time_ = 0;  // of a batch
    std::deque<ZoneEvent> zone_events_;
    mutable std::mutex states_mutex_;  // held while what follows is changed or asked for its state; fixes go to the sinks that were there before the run
    std::vector<std::unique_ptr<SinkQueue>> sinks_;
    std::unique_ptr<LiveSenses> live_senses_;
};

}  // namespace roomfix
