// Frames on their way from a camera to its observer: few, and the newest ones.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>

#include "roomfix/connect/frame_source.hpp"

namespace roomfix {

struct FrameCount {
    long came = 0;
    long dropped = 0;  // of those that came
};

/// Safe between one thread that puts in and one that takes out.
class FrameQueue {
public:
    explicit FrameQueue(std::size_t most = 2) : most_(most) {}

    /// Makes room by dropping the oldest frame where the queue is full.
    void push(SourceFrame frame);
    /// Waits for a frame; false once the queue is closed and empty.
    bool pop(SourceFrame& frame);
    void close();

    FrameCount count() const;

private:
    const std::size_t most_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<SourceFrame> frames_;
    FrameCount count_;
    bool closed_ = false;
};

/// Reads a live source in a thread of its own and gives its frames to `use`, with the count so far, so that a slow observer never sees old
/// ones; `failed` gets the message where a frame cannot be read. Returns
/// when the source has ended or `stop` is set.
void follow_live(FrameSource& source, const std::atomic<bool>& stop, const std::function<void(const SourceFrame&, const FrameCount&)>& use,
                 const std::function<void(const std::string&)>& failed);

}  // namespace roomfix
