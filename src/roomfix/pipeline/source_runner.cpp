#include "roomfix/pipeline/source_runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "roomfix/base/steady_now.hpp"
#include "roomfix/base/worker_pool.hpp"
#include "roomfix/pipeline/input_doctor.hpp"
#include "roomfix/pipeline/live_frames.hpp"
#include "roomfix/pipeline/live_senses.hpp"
#include "roomfix/pipeline/recorded_frames.hpp"
#include "roomfix/pipeline/recorded_senses.hpp"
#include "roomfix/pipeline/session_recorder.hpp"
#include "roomfix/pipeline/sink_queue.hpp"

namespace roomfix {

SourceRunner::SourceRunner(SiteTracker& tracker) : tracker_(tracker), recorded_(std::make_unique<RecordedSenses>()), zones_(tracker.site().zones) {
    tracker_.on_fixes([this](const FixBatch& batch) {
        last_batch_ = steady_now();
        if (!sinks_.empty() || recorder_ != nullptr) give(batch);
    });
    tracker_.before_frames([this](Nanoseconds time) { process_senses_until(time); });
}

/// To the recording and all sinks, with what it says about zones.
void SourceRunner::give(FixBatch batch) {
    constexpr std::size_t most_events = 50;
    {
        const std::lock_guard lock(zones_mutex_);
        last_time_ = batch.time;
        zones_.watch(batch);
        zone_events_.insert(zone_events_.end(), batch.zone_events.begin(), batch.zone_events.end());
        while (zone_events_.size() > most_events) zone_events_.pop_front();
    }
    const auto shared = std::make_shared<const FixBatch>(std::move(batch));
    if (recorder_ != nullptr) recorder_->give(shared);
    for (const auto& sink : sinks_) sink->give(shared);
}

void SourceRunner::set_zones(std::vector<SiteZone> zones) {
    Nanoseconds last = 0;
    {
        const std::lock_guard lock(zones_mutex_);
        zones_.set_zones(std::move(zones));
        ++zones_version_;
        last = last_time_;
    }
    give({last, {}, tracker_.fixes(last)});  // whoever shows zones hears of it, even if nothing else comes
}

std::pair<std::vector<SiteZone>, int> SourceRunner::zones() const {
    const std::lock_guard lock(zones_mutex_);
    return {zones_.zones(), zones_version_};
}

std::vector<ZoneEvent> SourceRunner::zone_events() const {
    const std::lock_guard lock(zones_mutex_);
    return {zone_events_.begin(), zone_events_.end()};
}

/// The page, which is the last sink, may ask for the state of the others as long as it is there.
SourceRunner::~SourceRunner() {
    while (true) {
        std::unique_ptr<SinkQueue> last;
        {
            const std::lock_guard lock(states_mutex_);
            if (sinks_.empty()) return;
            last = std::move(sinks_.back());
            sinks_.pop_back();
        }
        last.reset();  // not while its own threads may want that lock
    }
}

void SourceRunner::add_sink(std::unique_ptr<FixSink> sink, Overflow overflow, std::size_t capacity) {
    const std::lock_guard lock(states_mutex_);
    sinks_.push_back(std::make_unique<SinkQueue>(std::move(sink), capacity, overflow));
}

void SourceRunner::record_to(SessionRecorder& recorder) {
    recorder_ = &recorder;
    tracker_.tap_senses({[&recorder](const RangeBatch& batch) { recorder.give(batch); }, [&recorder](const SightingBatch& batch) { recorder.give(batch); },
                         [&recorder](const OdometryBatch& batch) { recorder.give(batch); }});
}

Result<void> SourceRunner::finish_sinks() {
    Result<void> first;
    for (const auto& sink : sinks_) {
        if (auto finished = sink->finish(); !finished && first) first = finished;
    }
    return first;
}

std::vector<SinkState> SourceRunner::sink_states() const {
    const std::lock_guard lock(states_mutex_);
    std::vector<SinkState> states;
    for (const auto& sink : sinks_) states.push_back(sink->state());
    if (recorder_ != nullptr) {
        const RecordingState recording = recorder_->state();
        states.push_back({"the recording", recording.ok ? "ok" : "failed", recording.message, recording.lost});
    }
    return states;
}

std::vector<SenseState> SourceRunner::sense_states() const {
    const std::lock_guard lock(states_mutex_);
    return live_senses_ ? live_senses_->states() : std::vector<SenseState>();
}

std::vector<std::string> SourceRunner::suspicious_inputs() const {
    std::vector<std::string> told;
    const std::vector<SiteRobot>& robots = tracker_.site().robots;
    for (std::size_t r = 0; r < robots.size(); ++r) {
        const int robot = static_cast<int>(r);
        if (robots[r].many) continue;
        for (const std::string& suspicion : suspicions(tracker_.tracker(), robot, recorded_->of(robot))) told.push_back(suspicion);
    }
    return told;
}

/// Recorded ranges, sightings and odometry up to a time, as they would have come.
void SourceRunner::process_senses_until(Nanoseconds time) {
    const std::lock_guard lock(senses_mutex_);
    SenseListener listener;
    listener.goes_on = [this](Nanoseconds next) { tracker_.go_on(next); };
    listener.hears = [this](const RangeBatch& batch) { tracker_.process(batch); };
    listener.drives = [this](const OdometryBatch& batch) { tracker_.process(batch); };
    listener.detects = [this](const SightingBatch& batch) { tracker_.process(batch); };
    recorded_->tell_until(time, listener);
}

Result<void> SourceRunner::run(const RunSettings& settings, const std::atomic<bool>& stop, const std::function<void(double)>& progress) {
    std::vector<std::unique_ptr<FrameSource>> sources;
    for (std::size_t i = 0; i < tracker_.cameras(); ++i) {
        const SiteCamera& camera = tracker_.camera(i);
        auto source = open_lasting_source(resolved_path(tracker_.site(), camera.source), {camera.capture, camera.model.width, camera.model.height});
        if (!source) return Error{fmt::format("camera {}: {}", camera.id, source.error().message)};
        sources.push_back(std::move(*source));
    }
    return run(std::move(sources), settings, stop, progress);
}

Result<void> SourceRunner::load_senses() {
    const std::vector<SiteRobot>& robots = tracker_.site().robots;
    auto recorded = RecordedSenses::load(tracker_.site());
    if (!recorded) return recorded.error();
    *recorded_ = std::move(*recorded);
    for (std::size_t r = 0; r < robots.size(); ++r) {
        const int robot = static_cast<int>(r);
        const std::string wrong = wrong_units(recorded_->of(robot).odometry, robots[r]);
        if (!wrong.empty()) recorded_->drop_odometry(robot, wrong);
    }
    tracker_.add_problems(recorded_->problems());
    return {};
}

Result<void> SourceRunner::run(std::vector<std::unique_ptr<FrameSource>> sources, const RunSettings& settings, const std::atomic<bool>& stop,
                               const std::function<void(double)>& progress) {
    if (auto loaded = load_senses(); !loaded) return loaded;
    for (const auto& source : sources) {
        if (recorder_ != nullptr) source->keep_files();
    }
    {
        const std::lock_guard lock(states_mutex_);
        live_senses_ = std::make_unique<LiveSenses>(tracker_, stop);
    }
    std::vector<LiveSource> live;
    for (std::size_t i = 0; i < sources.size(); ++i) {
        if (sources[i]->live()) live.push_back({i, sources[i].get()});
    }
    std::vector<std::thread> threads;
    if (!live.empty()) {
        if (settings.on_time) tracker_.measure_latency({steady_now(), system_now(), 1});
        threads.emplace_back([&] { run_live(live, settings.threads, stop); });
    }
    if (live_senses_->listens()) threads.emplace_back([&] { tell_of_silence(stop); });
    auto done = run_recorded(sources, settings, stop, progress);
    for (auto& thread : threads) thread.join();
    live_senses_->wait();
    const std::lock_guard lock(states_mutex_);
    live_senses_.reset();
    return done;
}

/// Sinks that show how cameras are doing hear of it, even if no camera is left whose frames would tell them. Nothing is due.
void SourceRunner::tell_time(Nanoseconds now) { give({now, {}, tracker_.fixes(now)}); }

/// While robots' senses that come live, and all cameras, say nothing: so that it is seen how they fare.
void SourceRunner::tell_of_silence(const std::atomic<bool>& stop) {
    constexpr double patience = 1;  // s
    while (!stop) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        if (steady_now() - last_batch_ < patience) continue;
        last_batch_ = steady_now();
        tell_time(system_now());
    }
}

/// Cameras that see the same moment are looked at together, as in a recording.
void SourceRunner::run_live(const std::vector<LiveSource>& sources, int threads, const std::atomic<bool>& stop) {
    LiveFrames::Listener listener;
    listener.failed = [this](std::size_t i, const std::string& message) { tracker_.set_camera_state(i, "failed", message); };
    listener.away = [this](std::size_t i, const std::string& message) {
        tracker_.set_camera_state(i, "away", message + "; trying again");
        tell_time(system_now());
    };
    listener.ended = [this](std::size_t i) { tracker_.set_camera_state(i, "ended", "the camera gives no more frames"); };
    LiveFrames frames(sources, stop, std::move(listener));
    WorkerPool pool(std::max(threads, 1));
    for (auto round = frames.next_round(); !round.empty(); round = frames.next_round()) {
        std::vector<CameraFrame> together;
        for (const LiveFrame& frame : round) tracker_.note_source(frame.camera, frame.note);
        for (std::size_t i = 0; i < round.size(); ++i) {
            const SourceFrame& frame = round[i].frame;
            together.push_back({round[i].camera, {frame.image, &frame.colour}, frame.time, frame.time_error});
            const bool last = i + 1 == round.size() || round[i + 1].frame.time - together.front().time > round_span;
            if (!last) continue;
            (void)tracker_.process(together, pool);
            together.clear();
        }
        for (LiveFrame& frame : round) {
            tracker_.count_dropped(frame.camera, frame.count.came, frame.count.dropped);
            if (recorder_ != nullptr) recorder_->give(frame.camera, std::move(frame.frame));
        }
    }
}

}  // namespace roomfix
