#include "roomfix/connect/v4l2_camera.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <span>
#include <utility>
#include <vector>

#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/imaging/yuv_picture.hpp"

namespace roomfix {
namespace {

constexpr std::uint32_t buffers_wanted = 4;
constexpr double stall = 3;    // s without a picture
constexpr double slice = 0.2;  // s between looks whether to stop
constexpr std::uint32_t capture = V4L2_BUF_TYPE_VIDEO_CAPTURE;

/// Both clocks, as close to one moment as can be.
ClockPair clocks_now() {
    const auto monotonic = [] {
        timespec t{};
        clock_gettime(CLOCK_MONOTONIC, &t);
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    };
    const double before = monotonic();
    const Nanoseconds system = system_now();
    return {0.5 * (before + monotonic()), system};
}

class V4l2Camera final : public FrameSource {
public:
    V4l2Camera(std::unique_ptr<VideoDevice> device, std::string path) : device_(std::move(device)), path_(std::move(path)) {}
    ~V4l2Camera() override {
        std::uint32_t type = capture;
        (void)device_->control(VIDIOC_STREAMOFF, &type);
    }
    V4l2Camera(const V4l2Camera&) = delete;
    V4l2Camera& operator=(const V4l2Camera&) = delete;

    Result<void> start(const LiveSettings& settings);

    Result<bool> advance(SourceFrame& frame) override;
    Result<void> decode(SourceFrame& frame) override;
    void keep_files() override { keeps_files_ = true; }
    bool live() const override { return true; }
    std::int64_t count() const override { return -1; }
    std::string note() const override { return note_; }
    std::int64_t passed_over() const override { return passed_over_; }
    void interrupt() override { stop_ = true; }

private:
    Result<void> set_format(const LiveSettings& settings);
    void set_rate(const std::optional<double>& rate);
    Result<void> map_buffers();
    Result<bool> take_newest();
    int give_back(v4l2_buffer buffer) { return device_->control(VIDIOC_QBUF, &buffer); }
    Error failed(const char* what, int code) const { return Error{fmt::format("{}: {}: {}", path_, what, std::strerror(code))}; }
    void note_times(const StampedTime& stamped);

    std::unique_ptr<VideoDevice> device_;
    std::string path_;
    VideoMode mode_;
    std::ptrdiff_t stride_ = 0;
    double interval_ = 0;  // s between pictures
    bool keeps_files_ = false;
    double readout_ = 0;  // s from when the first row is exposed until the last one is
    AppliedSettings applied_;
    std::vector<std::span<std::uint8_t>> buffers_;
    std::optional<v4l2_buffer> held_;  // the picture that is looked at
    std::string note_;
    std::int64_t frames_ = 0;
    std::int64_t passed_over_ = 0;
    std::atomic<bool> stop_{false};
};

Result<void> V4l2Camera::start(const LiveSettings& settings) {
    if (auto set = set_format(settings); !set) return set;
    readout_ = settings.capture.readout;
    set_rate(settings.capture.rate);
    applied_ = apply_settings(*device_, settings.capture);
    if (auto mapped = map_buffers(); !mapped) return mapped;
    std::uint32_t type = capture;
    if (const int code = device_->control(VIDIOC_STREAMON, &type); code != 0) {
        if (code == ENOSPC) return Error{fmt::format("{}: this USB bus has no room for another camera: use MJPEG, a smaller picture, or another port", path_)};
        return failed("the camera does not start", code);
    }
    return {};
}

Result<void> V4l2Camera::set_format(const LiveSettings& settings) {
    const std::vector<VideoMode> modes = video_modes(*device_);
    if (modes.empty()) return Error{fmt::format("{}: it gives neither YUYV nor MJPEG nor GREY: use another camera", path_)};
    const auto mode = choose_mode(modes, settings.width, settings.height, settings.capture.rate);
    if (!mode) {
        return Error{fmt::format("{}: it gives no pictures of {} x {}: 'roomfix cameras' lists what it gives; correct 'size' in the site file", path_,
                                 settings.width, settings.height)};
    }
    v4l2_format format{};
    format.type = capture;
    format.fmt.pix.width = static_cast<std::uint32_t>(mode->width);
    format.fmt.pix.height = static_cast<std::uint32_t>(mode->height);
    format.fmt.pix.pixelformat = mode->fourcc;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    const int code = device_->control(VIDIOC_S_FMT, &format);
    if (code == EBUSY) return Error{fmt::format("{}: another program uses this camera: close it", path_)};
    if (code != 0) return failed("the camera does not take its own format", code);
    const v4l2_pix_format& got = format.fmt.pix;
    if (got.pixelformat != mode->fourcc || got.width != static_cast<std::uint32_t>(mode->width) || got.height != static_cast<std::uint32_t>(mode->height)) {
        return Error{fmt::format("{}: it lists pictures of {} x {} in {} but does not give them: choose another size", path_, mode->width, mode->height,
                                 name_of(mode->format))};
    }
    mode_ = *mode;
    const std::ptrdiff_t least = mode_.format == VideoFormat::yuyv ? 2 * std::ptrdiff_t{mode_.width} : mode_.width;
    stride_ = std::max<std::ptrdiff_t>(got.bytesperline, least);
    return {};
}

void V4l2Camera::set_rate(const std::optional<double>& rate) {
    v4l2_streamparm parameters{};
    parameters.type = capture;
    v4l2_fract& interval = parameters.parm.capture.timeperframe;
    interval_ = 1 / (mode_.rate > 0 ? mode_.rate : 25);
    interval = {1000, static_cast<std::uint32_t>(std::lround(1000 * rate.value_or(1 / interval_)))};
    if (device_->control(VIDIOC_S_PARM, &parameters) != 0 || interval.denominator == 0 || interval.numerator == 0) return;
    interval_ = static_cast<double>(interval.numerator) / interval.denominator;
}

Result<void> V4l2Camera::map_buffers() {
    v4l2_requestbuffers request{};
    request.count = buffers_wanted;
    request.type = capture;
    request.memory = V4L2_MEMORY_MMAP;
    if (const int code = device_->control(VIDIOC_REQBUFS, &request); code == EBUSY) {
        return Error{fmt::format("{}: another program uses this camera: close it", path_)};
    } else if (code != 0) {
        return failed("the camera has no buffers to be mapped", code);
    }
    for (std::uint32_t i = 0; i < request.count; ++i) {
        v4l2_buffer buffer{};
        buffer.index = i;
        buffer.type = capture;
        buffer.memory = V4L2_MEMORY_MMAP;
        if (const int code = device_->control(VIDIOC_QUERYBUF, &buffer); code != 0) return failed("a buffer is missing", code);
        buffers_.push_back(device_->map(buffer.length, buffer.m.offset));
        if (buffers_.back().empty()) return Error{fmt::format("{}: a buffer cannot be mapped: is there memory left?", path_)};
        if (const int code = give_back(buffer); code != 0) return failed("a buffer is not taken", code);
    }
    if (buffers_.size() < 2) return Error{fmt::format("{}: the camera has too few buffers", path_)};
    return {};
}

/// Takes all pictures that wait and holds the newest whole one. False if there is none.
Result<bool> V4l2Camera::take_newest() {
    bool found = false;
    while (true) {
        v4l2_buffer buffer{};
        buffer.type = capture;
        buffer.memory = V4L2_MEMORY_MMAP;
        const int code = device_->control(VIDIOC_DQBUF, &buffer);
        if (code == EAGAIN) return found;
        if (code == ENODEV) return Error{fmt::format("{}: the camera was unplugged", path_)};
        if (code != 0) return failed("the camera gives no picture", code);
        if (buffer.index >= buffers_.size()) return Error{fmt::format("{}: the driver names a buffer that does not exist", path_)};
        const bool whole = (buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 && buffer.bytesused > 0;
        if (!whole) {
            (void)give_back(buffer);
            continue;
        }
        if (held_) {
            (void)give_back(*held_);
            passed_over_ += found;
        }
        held_ = buffer;
        found = true;
    }
}

Result<bool> V4l2Camera::advance(SourceFrame& frame) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(stall);
    while (std::chrono::steady_clock::now() < until) {
        if (stop_) return false;
        if (!device_->wait(slice)) continue;
        const auto taken = take_newest();
        if (!taken) return taken.error();
        if (!*taken) continue;
        const BufferStamp stamp{static_cast<double>(held_->timestamp.tv_sec) + 1e-6 * static_cast<double>(held_->timestamp.tv_usec),
                                (held_->flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC,
                                (held_->flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE};
        const StampedTime stamped = middle_of_exposure(stamp, clocks_now(), applied_.exposure, interval_, readout_);
        frame.time = stamped.time;
        frame.time_error = stamped.error;
        frame.name = std::to_string(++frames_);
        if (frames_ % 100 == 1) note_times(stamped);
        return true;
    }
    return Error{fmt::format("{}: no picture for {:.0f} s: unplug the camera and plug it in again", path_, stall)};
}

void V4l2Camera::note_times(const StampedTime& stamped) {
    note_ = fmt::format("{} x {}, {}, {:.3g} pictures/s; times are the driver's, +-{:.0f} ms", mode_.width, mode_.height, name_of(mode_.format), 1 / interval_,
                        std::ceil(1e3 * stamped.error.sigma));
    if (!applied_.told.empty()) note_ += "; " + applied_.told;
}

Result<void> V4l2Camera::decode(SourceFrame& frame) {
    if (!held_) return Error{"there is no picture"};
    const std::span<const std::uint8_t> buffer = buffers_[held_->index];
    const auto bytes = buffer.first(std::min<std::size_t>(held_->bytesused, buffer.size()));
    frame.encoded.clear();
    frame.file = {};
    if (mode_.format == VideoFormat::mjpeg) {
        frame.encoded.assign(bytes.begin(), bytes.end());
        return decode_picture(frame.encoded, frame.image, frame.colour);
    }
    const int pixel_bytes = mode_.format == VideoFormat::yuyv ? 2 : 1;
    const auto needed = static_cast<std::size_t>(stride_ * (mode_.height - 1) + std::ptrdiff_t{mode_.width} * pixel_bytes);
    if (bytes.size() < needed) return Error{fmt::format("a picture has {} bytes instead of {}: it was cut off on its way", bytes.size(), needed)};
    if (mode_.format == VideoFormat::grey) {
        const LumaView grey{bytes.data(), mode_.width, mode_.height, stride_};
        frame.image = copy_of(grey);
        shrink_grey(grey, frame.colour);
        return {};
    }
    const YuvView picture = yuyv_view(bytes.data(), mode_.width, mode_.height, stride_);
    if (keeps_files_) frame.file = yuv_file(picture);
    luma_from_yuv(picture, frame.image);
    colour_from_yuv(picture, frame.colour);
    return {};
}

}  // namespace

Result<std::unique_ptr<FrameSource>> start_v4l2_camera(std::unique_ptr<VideoDevice> device, const std::string& path, const LiveSettings& settings) {
    auto camera = std::make_unique<V4l2Camera>(std::move(device), path);
    if (auto started = camera->start(settings); !started) return started.error();
    return std::unique_ptr<FrameSource>(std::move(camera));
}

Result<std::unique_ptr<FrameSource>> open_v4l2_camera(const std::string& path, const LiveSettings& settings) {
    auto device = open_video_device(path);
    if (!device) return device.error();
    return start_v4l2_camera(std::move(*device), path, settings);
}

}  // namespace roomfix
