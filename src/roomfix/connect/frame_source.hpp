// Frames with their times from image folders, video files, cameras and network streams.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/base/time.hpp"
#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/imaging/yuv_picture.hpp"
#include "roomfix/observation/time_error.hpp"
#include "roomfix/site/capture.hpp"

namespace roomfix {

/// A picture as a file of its own.
struct PictureFile {
    std::vector<std::uint8_t> bytes;
    std::string ending;  // of its name: jpg, png, ...
};

struct SourceFrame {
    LumaImage image;
    ColourImage colour;  // of the same frame
    Nanoseconds time = 0;
    TimeError time_error;
    std::string name;                           // file name, or the frame's number in a video
    std::vector<std::uint8_t> encoded;          // the JPEG as a live camera gave it; empty where it gave something else
    std::function<Result<PictureFile>()> file;  // once, from any thread: the frame as it came; empty unless the source was told to keep it
};

/// Where a camera's frames come from.
class FrameSource {
public:
    virtual ~FrameSource() = default;
    /// True with the next frame's time and name, but without its picture; false at the end, an error if nothing can be read (the next call goes on
    /// behind it). A live source does not wait for ever: where no frame comes for some seconds, that is an error.
    virtual Result<bool> advance(SourceFrame& frame) = 0;
    /// The picture of the frame that `advance` came to. An error if it cannot be read.
    virtual Result<void> decode(SourceFrame& frame) = 0;
    /// Both.
    Result<bool> next(SourceFrame& frame);
    /// True if frames come when they come; false if they wait to be fetched.
    virtual bool live() const = 0;
    /// Frames that will come, or -1 if nobody knows.
    virtual std::int64_t count() const = 0;
    /// What is to be said of a live camera: where its times come from, what it sets by itself. Asked by the thread that calls `advance`.
    virtual std::string note() const { return ""; }
    /// Frames that came but were never given, since newer ones were there.
    virtual std::int64_t passed_over() const { return 0; }
    /// From any thread: `advance` comes back soon, and nothing more comes.
    virtual void interrupt() {}
    /// From now on frames have their `file`: the bytes as they came, where the source has them, otherwise the picture without loss. Live sources that get
    /// JPEGs give them as `encoded`.
    virtual void keep_files() {}
};

/// What a live camera is asked for.
struct LiveSettings {
    CaptureSettings capture;
    int width = 0, height = 0;  // px; 0: as the camera likes
};

/// A frame's picture as the camera or the decoder gave it, nothing lost, as a Y4M file; empty where none can hold it.
std::function<Result<PictureFile>()> yuv_file(const YuvView& picture);

/// A frame of which only the grey picture is left, as PNG.
Result<PictureFile> grey_file(const LumaImage& image);

/// A file of this name in a folder without pictures says that this is right: the camera gave none while it was recorded.
constexpr const char* no_frames_mark = "no-frames";

/// Opens an image folder (files in the order of their names; a name that is a whole number is the time in nanoseconds,
/// otherwise frames are 0.1 s apart), one picture, a video file, a camera (/dev/videoN), or an rtsp:// or http:// address.
/// An error says why it cannot be opened and what to try.
Result<std::unique_ptr<FrameSource>> open_source(const std::string& source, const LiveSettings& settings = {});
/// The same for a program that runs on: a camera that is not there yet, or vanishes, is no error of this call but one of `advance`, and is opened
/// again when it comes.
Result<std::unique_ptr<FrameSource>> open_lasting_source(const std::string& source, const LiveSettings& settings = {});

}  // namespace roomfix
