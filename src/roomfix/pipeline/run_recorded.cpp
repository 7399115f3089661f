// The part of a site's work that runs recordings.
#include <algorithm>
#include <chrono>
#include <thread>

#include "roomfix/base/steady_now.hpp"
#include "roomfix/base/worker_pool.hpp"
#include "roomfix/pipeline/live_frames.hpp"
#include "roomfix/pipeline/recorded_frames.hpp"
#include "roomfix/pipeline/recorded_senses.hpp"
#include "roomfix/pipeline/session_recorder.hpp"
#include "roomfix/pipeline/sink_queue.hpp"
#include "roomfix/pipeline/source_runner.hpp"

namespace roomfix {
namespace {

constexpr double too_late = 0.3;  // s behind the clock: a frame that is not looked at any more

void wait_until(double due, const std::atomic<bool>& stop) {
    while (!stop && steady_now() < due) std::this_thread::sleep_for(std::chrono::duration<double>(std::clamp(due - steady_now(), 0.0, 0.05)));
}

}  // namespace

/// Round by round, so that the fixes do not depend on the number of threads.
Result<void> SourceRunner::run_recorded(std::vector<std::unique_ptr<FrameSource>>& sources, const RunSettings& settings, const std::atomic<bool>& stop,
                                        const std::function<void(double)>& progress) {
    std::vector<FrameCount> counts(sources.size());
    std::optional<Pace> pace;
    RecordedFrames::Listener listener;
    listener.failed = [this](std::size_t i, const std::string& message) { tracker_.set_camera_state(i, "failed", message); };
    listener.ended = [this](std::size_t i) { tracker_.set_camera_state(i, "ended", "the recording ended"); };
    listener.decoded = [this](double seconds) { tracker_.stage_times().add(Stage::decode, seconds); };
    listener.too_late = [&](std::size_t i, Nanoseconds time) {
        const bool late = settings.on_time && pace && steady_now() > pace->wall_of(time) + too_late;
        counts[i].came += late;
        counts[i].dropped += late;
        return late;
    };
    const auto keep_pace = [&](Nanoseconds first, Nanoseconds last) {
        if (settings.speed <= 0) return;
        if (!pace) pace = Pace{steady_now(), first, settings.speed};
        if (settings.on_time && !tracker_.measures_latency()) tracker_.measure_latency(*pace);
        wait_until(pace->wall_of(last), stop);
    };
    RecordedFrames frames(sources, stop, listener);
    WorkerPool pool(std::max(settings.threads, 1));
    double done = 0;
    for (auto round = frames.next_round(); !round.empty() && !stop; round = frames.next_round()) {
        const Nanoseconds first = frames.time_of(round.front());
        keep_pace(first, frames.time_of(round.back()));
        std::vector<SourceFrame> taken;
        taken.reserve(round.size());  // the frames to look at point into it
        std::vector<CameraFrame> looked_at;
        for (const std::size_t camera : round) {
            taken.push_back(frames.take(camera));
            ++counts[camera].came;
            looked_at.push_back({camera, {taken.back().image, &taken.back().colour}, taken.back().time, taken.back().time_error});
        }
        process_senses_until(first);
        tracker_.go_on(first);
        auto fed = tracker_.process(looked_at, pool);
        for (std::size_t i = 0; i < round.size() && recorder_ != nullptr; ++i) recorder_->give(round[i], std::move(taken[i]));
        if (!fed && counts[round.front()].came == 1) return fed;  // the very first frame does not fit: nothing will
        pool.run(static_cast<int>(round.size()), [&](int job) { frames.advance(round[static_cast<std::size_t>(job)]); });
        for (const std::size_t camera : round) tracker_.count_dropped(camera, counts[camera].came, counts[camera].dropped);
        done += static_cast<double>(round.size());
        if (progress) progress(std::min(1.0, done / std::max(frames.total(), 1.0)));
    }
    // What was sensed after the last frame, or without any.
    for (auto next = recorded_->next_time(); next && !stop; next = recorded_->next_time()) {
        keep_pace(*next, *next);
        process_senses_until(*next);
    }
    return {};
}

}  // namespace roomfix
