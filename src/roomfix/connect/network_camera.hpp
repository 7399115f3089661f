// Cameras on the network: RTSP, HTTP (MJPEG), and whatever else libav reads from an address.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/stream_clock.hpp"

namespace roomfix {

/// True for `rtsp://...`, `http://...` and the like.
bool is_network_address(const std::string& source);

/// One connection to a camera. It is read in a thread of its own: `advance` gives the newest picture, however long the one before took, and is an error once
/// none came for three seconds. `clock` is the camera's, and outlives the connection; only one connection may use it at a time.
Result<std::unique_ptr<FrameSource>> open_network_camera(const std::string& address, std::shared_ptr<StreamClock> clock, const std::atomic<bool>& stop);

}  // namespace roomfix
