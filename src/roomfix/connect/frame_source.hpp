// Frames with their times from image folders, video files, cameras and network streams.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/base/time.hpp"
#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct SourceFrame {
    LumaImage image;
    ColourImage colour;  // of the same frame
    Nanoseconds time = 0;
    std::string name;  // file name, or the frame's number in a video
};

/// Where a camera's frames come from.
class FrameSource {
public:
    virtual ~FrameSource() = default;
    /// True with the next frame's time and name, but without its picture; false at the end, an error if nothing can be read (the next call goes on
    /// behind it).
    virtual Result<bool> advance(SourceFrame& frame) = 0;
    /// The picture of the frame that `advance` came to. An error if it cannot be read.
    virtual Result<void> decode(SourceFrame& frame) = 0;
    /// Both.
    Result<bool> next(SourceFrame& frame);
    /// True if frames come when they come; false if they wait to be fetched.
    virtual bool live() const = 0;
    /// Frames that will come, or -1 if nobody knows.
    virtual std::int64_t count() const = 0;
};

/// Opens an image folder (files in the order of their names; a name that is a whole number is the time in nanoseconds,
/// otherwise frames are 0.1 s apart), one picture, a video file, /dev/videoN, or an rtsp:// or http:// address.
/// An error says why it cannot be opened and what to try.
Result<std::unique_ptr<FrameSource>> open_source(const std::string& source);

}  // namespace roomfix
