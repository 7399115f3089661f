// Recorded frames of several cameras in the order of their times, a round of different cameras at once.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "roomfix/connect/frame_source.hpp"

namespace roomfix {

/// Frames of different cameras no farther apart are looked at together: what a frame tells about the next ones is that old at most.
constexpr Nanoseconds round_span = 40'000'000;

class RecordedFrames {
public:
    struct Listener {
        std::function<void(std::size_t, const std::string&)> failed;  // a camera, and the message where a frame cannot be read
        std::function<void(std::size_t)> ended;                       // a camera
        std::function<void(double)> decoded;                          // s that it took; may be empty
        std::function<bool(std::size_t, Nanoseconds)> too_late;       // a frame of a camera that is not worth decoding any more; may be empty
    };
    /// Live ones among the sources are left alone.
    RecordedFrames(std::vector<std::unique_ptr<FrameSource>>& sources, const std::atomic<bool>& stop, Listener listener);

    /// The next frames that may be looked at side by side: the earliest of all, and those of other cameras little later, in the order of
    /// their times. Empty at the end.
    std::vector<std::size_t> next_round() const;
    Nanoseconds time_of(std::size_t camera) const { return waiting_[camera]->time; }
    /// Hands the camera's frame out; call `advance` next.
    SourceFrame take(std::size_t camera) { return std::move(*waiting_[camera]); }
    /// Goes on to the camera's next frame; from any thread, but for one camera from one at a time.
    void advance(std::size_t camera);

    /// Frames that will come of all cameras.
    double total() const { return total_; }

private:
    std::vector<std::unique_ptr<FrameSource>>& sources_;
    const std::atomic<bool>& stop_;
    Listener listener_;
    std::vector<std::optional<SourceFrame>> waiting_;
    double total_ = 0;
};

}  // namespace roomfix
