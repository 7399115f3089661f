#include "roomfix/pipeline/live_frames.hpp"

#include <algorithm>
#include <chrono>

#include "roomfix/base/steady_now.hpp"

namespace roomfix {
namespace {

constexpr double old = 0.06;           // s that a frame has waited, from which on a newer one takes its place
constexpr double gathering = 0.02;     // s for which the first frame of a round waits for those of other cameras
constexpr double stop_interval = 0.1;  // s between looks whether to stop
constexpr auto retry_interval = std::chrono::milliseconds(200);

std::chrono::duration<double> seconds(double s) { return std::chrono::duration<double>(s); }

}  // namespace

LiveFrames::LiveFrames(const std::vector<LiveSource>& sources, const std::atomic<bool>& stop, Listener listener)
    : stop_(stop), listener_(std::move(listener)), slots_(sources.size()) {
    for (std::size_t i = 0; i < sources.size(); ++i) {
        slots_[i].camera = sources[i].camera;
        slots_[i].source = sources[i].source;
    }
    for (Slot& slot : slots_) readers_.emplace_back([this, &slot] { read(slot); });
}

LiveFrames::~LiveFrames() {
    if (stop_) {
        for (Slot& slot : slots_) slot.source->interrupt();
    }
    for (std::thread& reader : readers_) reader.join();
}

/// Counts a frame that came. False where the one before it waits and is still young.
bool LiveFrames::takes_place(Slot& slot) {
    const auto passed_over = static_cast<long>(slot.source->passed_over());
    const std::lock_guard lock(mutex_);
    slot.count.came += 1 + passed_over - slot.passed_over;
    slot.count.dropped += passed_over - slot.passed_over;
    slot.passed_over = passed_over;
    slot.away = false;
    if (!slot.frame || steady_now() - slot.came >= old) return true;
    ++slot.count.dropped;
    return false;
}

void LiveFrames::set_away(Slot& slot) {
    const std::lock_guard lock(mutex_);
    slot.away = true;
}

void LiveFrames::read(Slot& slot) {
    SourceFrame frame;
    while (!stop_) {
        const auto more = slot.source->advance(frame);
        if (more && !*more) break;
        if (!more) {
            set_away(slot);
            listener_.away(slot.camera, more.error().message);
            std::this_thread::sleep_for(retry_interval);
            continue;
        }
        if (!takes_place(slot)) continue;
        const double came = steady_now();
        if (const auto decoded = slot.source->decode(frame); !decoded) {
            listener_.failed(slot.camera, decoded.error().message);
            continue;
        }
        std::string note = slot.source->note();
        {
            const std::lock_guard lock(mutex_);
            slot.count.dropped += slot.frame.has_value();
            slot.frame = std::move(frame);
            slot.note = std::move(note);
            slot.came = came;
        }
        frame = {};
        changed_.notify_all();
    }
    {
        const std::lock_guard lock(mutex_);
        slot.ended = true;
    }
    if (!stop_) listener_.ended(slot.camera);
    changed_.notify_all();
}

bool LiveFrames::all_have() const {
    return std::all_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.frame || s.away || s.ended; });
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
        round.push_back({slot.camera, std::move(*slot.frame), slot.count, slot.note});
        slot.frame.reset();
    }
    std::stable_sort(round.begin(), round.end(), [](const LiveFrame& a, const LiveFrame& b) { return a.frame.time < b.frame.time; });
    return round;
}

}  // namespace roomfix
