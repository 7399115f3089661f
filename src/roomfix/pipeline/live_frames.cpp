#include "roomfix/pipeline/live_frames.hpp"

#include <algorithm>
#include <chrono>

#include "roomfix/pipeline/wall_clock.hpp"

namespace roomfix {
namespace {

constexpr double old = 0.06;           // s that a frame has waited, from which on a newer one takes its place
constexpr double gathering = 0.02;     // s for which the first frame of a round waits for those of other cameras
constexpr double stop_interval = 0.1;  // s between looks whether to stop
constexpr auto retry_interval = std::chrono::milliseconds(200);

std::chrono::duration<double> seconds(double s) { return std::chrono::duration<double>(s); }

}  // namespace

LiveFrames::LiveFrames(const std::vector<LiveSource>& sources, const std::atomic<bool>& stop, std::function<void(std::size_t, const std::string&)> failed,
                       std::function<void(std::size_t)> ended)
    : stop_(stop), failed_(std::move(failed)), ended_(std::move(ended)), slots_(sources.size()) {
    for (std::size_t i = 0; i < sources.size(); ++i) {
        slots_[i].camera = sources[i].camera;
        slots_[i].source = sources[i].source;
    }
    for (Slot& slot : slots_) readers_.emplace_back([this, &slot] { read(slot); });
}

LiveFrames::~LiveFrames() {
    for (std::thread& reader : readers_) reader.join();
}

void LiveFrames::read(Slot& slot) {
    SourceFrame frame;
    while (!stop_) {
        const auto more = slot.source->advance(frame);
        if (more && !*more) break;
        if (more) {
            std::unique_lock lock(mutex_);
            ++slot.count.came;
            if (slot.frame && wall_clock() - slot.came < old) {
                ++slot.count.dropped;
                continue;
            }
        }
        const double came = wall_clock();
        const auto decoded = more ? slot.source->decode(frame) : Result<void>(more.error());
        if (!decoded) {
            failed_(slot.camera, decoded.error().message);
            std::this_thread::sleep_for(retry_interval);
            continue;
        }
        {
            const std::lock_guard lock(mutex_);
            slot.count.dropped += slot.frame.has_value();
            slot.frame = std::move(frame);
            slot.came = came;
        }
        frame = {};
        changed_.notify_all();
    }
    {
        const std::lock_guard lock(mutex_);
        slot.ended = true;
    }
    ended_(slot.camera);
    changed_.notify_all();
}

bool LiveFrames::all_have() const {
    return std::all_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.frame || s.ended; });
}

bool LiveFrames::any_has() const {
    return std::any_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.frame.has_value(); });
}

bool LiveFrames::all_ended() const {
    return std::all_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.ended; });
}

std::vector<LiveFrame> LiveFrames::next_round() {
    std::unique_lock lock(mutex_);
    while (!any_has()) {
        if (stop_ || all_ended()) return {};
        changed_.wait_for(lock, seconds(stop_interval), [this] { return any_has() || all_ended(); });
    }
    changed_.wait_for(lock, seconds(gathering), [this] { return all_have(); });
    if (stop_) return {};
    std::vector<LiveFrame> round;
    for (Slot& slot : slots_) {
        if (!slot.frame) continue;
        round.push_back({slot.camera, std::move(*slot.frame), slot.count});
        slot.frame.reset();
    }
    std::stable_sort(round.begin(), round.end(), [](const LiveFrame& a, const LiveFrame& b) { return a.frame.time < b.frame.time; });
    return round;
}

}  // namespace roomfix
