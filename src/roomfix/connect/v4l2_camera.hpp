// A camera of the kernel (V4L2) as a source of frames: mapped buffers, their time stamps, and settings that stay as they are.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/stream_clock.hpp"
#include "roomfix/connect/video_device.hpp"

namespace roomfix {

/// Opens the camera at a path (`/dev/video0`, or a name that stays the same: `/dev/v4l/by-id/...`). An error says what to do.
Result<std::unique_ptr<FrameSource>> open_v4l2_camera(const std::string& path, const LiveSettings& settings);
/// The same on an open device; `path` is for messages.
Result<std::unique_ptr<FrameSource>> start_v4l2_camera(std::unique_ptr<VideoDevice> device, const std::string& path, const LiveSettings& settings);

/// What a camera's settings are after they were asked for.
struct AppliedSettings {
    std::optional<double> exposure;  // s, where it is fixed
    std::string told;                // what could not be set, and what the camera sets by itself
};
AppliedSettings apply_settings(VideoDevice& device, const CaptureSettings& wanted);

/// A buffer's time stamp.
struct BufferStamp {
    double seconds = 0;              // of the monotonic clock
    bool monotonic = true;           // false: of nobody knows which clock
    bool start_of_exposure = false;  // else when the picture had been read out
};
/// Both clocks at one moment.
struct ClockPair {
    double monotonic = 0;    // s
    Nanoseconds system = 0;  // of our clock
};
/// The middle of exposure of a picture's middle row by our clock. `interval` (s) is that between pictures: what is not known of exposure and reading out is
/// some part of it. `readout`: s from the first row's exposure to the last row's; 0: all at once, or not known.
StampedTime middle_of_exposure(const BufferStamp& stamp, const ClockPair& now, std::optional<double> exposure, double interval, double readout = 0);

}  // namespace roomfix
