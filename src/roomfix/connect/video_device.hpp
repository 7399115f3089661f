// A camera of the kernel (V4L2): the few system calls that it takes, and what it says of itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"

namespace roomfix {

/// The system calls, so that all that is done with them can be tried without a camera.
class VideoDevice {
public:
    virtual ~VideoDevice() = default;
    /// ioctl(2): 0, or the error's number.
    virtual int control(unsigned long request, void* argument) = 0;
    /// mmap(2) of a buffer; empty where that fails. It stays until the device is closed.
    virtual std::span<std::uint8_t> map(std::size_t length, std::int64_t offset) = 0;
    /// poll(2): true once a picture or an error waits, false after some seconds.
    virtual bool wait(double seconds) = 0;
};

/// True for `/dev/...`, but for files in memory (`/dev/shm`).
bool is_video_device(const std::string& source);
/// An error says what to do: no such camera, no permission, no camera at all.
Result<std::unique_ptr<VideoDevice>> open_video_device(const std::string& path);

enum class VideoFormat { yuyv, mjpeg, grey };
const char* name_of(VideoFormat format);

/// A way in which a camera gives pictures.
struct VideoMode {
    VideoFormat format = VideoFormat::yuyv;
    int width = 0, height = 0;  // px
    double rate = 0;            // the highest, pictures per second; 0: it does not say
    std::uint32_t fourcc = 0;   // what the driver calls the format

    bool operator==(const VideoMode&) const = default;
};

/// All ways in formats that are read, the largest first.
std::vector<VideoMode> video_modes(VideoDevice& device);
/// The best way for a size (0: any) and a rate: unpacked pictures where they come often enough, else JPEG; of any size the largest that does.
std::optional<VideoMode> choose_mode(const std::vector<VideoMode>& modes, int width, int height, std::optional<double> rate);

/// Which camera it is.
struct VideoDeviceInfo {
    std::string path;  // /dev/videoN
    std::string card;  // what it is called
    std::string bus;
    std::string serial;              // empty: it has none
    std::vector<std::string> links;  // names that stay the same: /dev/v4l/by-id/..., by-path/...
    std::vector<VideoMode> modes;
    std::string problem;  // not empty: why nothing more is known
};

/// The kernel's cameras, those that cannot be opened too. Devices that give no pictures (outputs, metadata) are left out.
std::vector<VideoDeviceInfo> list_video_devices();

}  // namespace roomfix
