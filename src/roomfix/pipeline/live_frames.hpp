// Frames of live cameras as they come: the newest of each, those of about the same moment together.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "roomfix/connect/frame_source.hpp"

namespace roomfix {

struct FrameCount {
    long came = 0;
    long dropped = 0;  // of those that came
};

/// A live camera by its place in the runner.
struct LiveSource {
    std::size_t camera = 0;
    FrameSource* source = nullptr;
};

struct LiveFrame {
    std::size_t camera = 0;
    SourceFrame frame;
    FrameCount count;  // of its camera so far
    std::string note;  // what its source says of itself
};

/// Every source is read in a thread of its own, so that a slow observer never sees old frames. A frame that comes while the one before it still waits
/// is not decoded, unless that one has become old.
class LiveFrames {
public:
    /// All are called from any thread, with the camera's place.
    struct Listener {
        std::function<void(std::size_t, const std::string&)> failed;  // a frame cannot be read
        std::function<void(std::size_t, const std::string&)> away;    // the camera gives nothing just now
        std::function<void(std::size_t)> ended;                       // the camera gives no more
    };
    LiveFrames(const std::vector<LiveSource>& sources, const std::atomic<bool>& stop, Listener listener);
    /// Interrupts the sources and waits for the readers.
    ~LiveFrames();

    /// Waits for a frame and, a little longer, for those of the other cameras. In the order of their times; empty once all sources have ended or
    /// `stop` is set.
    std::vector<LiveFrame> next_round();

private:
    struct Slot {
        std::size_t camera = 0;
        FrameSource* source = nullptr;
        std::optional<SourceFrame> frame;
        std::string note;
        double came = 0;  // s of the clock, when it came
        FrameCount count;
        long passed_over = 0;  // of the count: by the source itself
        bool away = false;     // nobody waits for it
        bool ended = false;
    };
    void read(Slot& slot);
    bool takes_place(Slot& slot);
    void set_away(Slot& slot);
    bool all_have() const;
    bool any_has() const;
    bool all_ended() const;

    const std::atomic<bool>& stop_;
    Listener listener_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<Slot> slots_;
    std::vector<std::thread> readers_;
};

}  // namespace roomfix
