#include "roomfix/connect/video_device.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "roomfix/base/number.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

constexpr double often_enough = 25;    // pictures per second, where no rate is asked for
constexpr unsigned most_listed = 200;  // formats, sizes, rates: more is a broken driver

class KernelDevice final : public VideoDevice {
public:
    explicit KernelDevice(int file) : file_(file) {}
    ~KernelDevice() override {
        for (const auto& buffer : mapped_) ::munmap(buffer.data(), buffer.size());
        ::close(file_);
    }
    KernelDevice(const KernelDevice&) = delete;
    KernelDevice& operator=(const KernelDevice&) = delete;

    int control(unsigned long request, void* argument) override {
        int result = 0;
        do {
            result = ::ioctl(file_, request, argument);
        } while (result < 0 && errno == EINTR);
        return result < 0 ? errno : 0;
    }
    std::span<std::uint8_t> map(std::size_t length, std::int64_t offset) override {
        void* memory = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, file_, offset);
        if (memory == MAP_FAILED) return {};
        mapped_.emplace_back(static_cast<std::uint8_t*>(memory), length);
        return mapped_.back();
    }
    bool wait(double seconds) override {
        pollfd waiting{file_, POLLIN, 0};
        const int ready = ::poll(&waiting, 1, static_cast<int>(seconds * 1000));
        return ready != 0;
    }

private:
    int file_;
    std::vector<std::span<std::uint8_t>> mapped_;
};

std::optional<VideoFormat> format_of(std::uint32_t fourcc) {
    switch (fourcc) {
        case V4L2_PIX_FMT_YUYV:
            return VideoFormat::yuyv;
        case V4L2_PIX_FMT_MJPEG:
        case V4L2_PIX_FMT_JPEG:
            return VideoFormat::mjpeg;
        case V4L2_PIX_FMT_GREY:
            return VideoFormat::grey;
        default:
            return std::nullopt;
    }
}

/// The shortest interval between pictures of a size, as their rate.
double highest_rate(VideoDevice& device, std::uint32_t fourcc, std::uint32_t width, std::uint32_t height) {
    double rate = 0;
    v4l2_frmivalenum interval{};
    interval.pixel_format = fourcc;
    interval.width = width;
    interval.height = height;
    for (; interval.index < most_listed && device.control(VIDIOC_ENUM_FRAMEINTERVALS, &interval) == 0; ++interval.index) {
        const v4l2_fract& shortest = interval.type == V4L2_FRMIVAL_TYPE_DISCRETE ? interval.discrete : interval.stepwise.min;
        if (shortest.numerator > 0) rate = std::max(rate, static_cast<double>(shortest.denominator) / shortest.numerator);
        if (interval.type != V4L2_FRMIVAL_TYPE_DISCRETE) break;
    }
    return rate;
}

/// Sizes that people use, of a camera that gives any size between two.
std::vector<std::pair<std::uint32_t, std::uint32_t>> sizes_within(const v4l2_frmsize_stepwise& steps) {
    constexpr std::array<std::pair<std::uint32_t, std::uint32_t>, 9> usual = {
        {{320, 240}, {640, 480}, {800, 600}, {1024, 768}, {1280, 720}, {1280, 960}, {1640, 1232}, {1920, 1080}, {3840, 2160}}};
    const auto reaches = [](std::uint32_t value, std::uint32_t least, std::uint32_t most, std::uint32_t step) {
        return value >= least && value <= most && (value - least) % std::max(step, 1U) == 0;
    };
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sizes = {{steps.max_width, steps.max_height}};
    for (const auto& [width, height] : usual) {
        const bool fits =
            reaches(width, steps.min_width, steps.max_width, steps.step_width) && reaches(height, steps.min_height, steps.max_height, steps.step_height);
        if (fits && sizes.front() != std::pair(width, height)) sizes.emplace_back(width, height);
    }
    return sizes;
}

void add_modes(VideoDevice& device, std::uint32_t fourcc, VideoFormat format, std::vector<VideoMode>& modes) {
    const auto add = [&](std::uint32_t width, std::uint32_t height) {
        modes.push_back({format, static_cast<int>(width), static_cast<int>(height), highest_rate(device, fourcc, width, height), fourcc});
    };
    v4l2_frmsizeenum size{};
    size.pixel_format = fourcc;
    for (; size.index < most_listed && device.control(VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
        if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
            add(size.discrete.width, size.discrete.height);
            continue;
        }
        for (const auto& [width, height] : sizes_within(size.stepwise)) add(width, height);
        break;
    }
}

std::string first_line(const fs::path& file) {
    std::string line;
    std::ifstream stream(file);
    std::getline(stream, line);
    return line;
}

/// The serial number of the USB device that a camera is a part of.
std::string serial_of(const std::string& name) {
    std::error_code failure;
    fs::path folder = fs::canonical(fs::path("/sys/class/video4linux") / name / "device", failure);
    for (int up = 0; !failure && up < 3; ++up, folder = folder.parent_path()) {
        if (const std::string serial = first_line(folder / "serial"); !serial.empty()) return serial;
    }
    return "";
}

std::vector<std::string> links_to(const fs::path& device) {
    std::vector<std::string> links;
    for (const char* folder : {"/dev/v4l/by-id", "/dev/v4l/by-path"}) {
        std::error_code failure;
        for (const auto& entry : fs::directory_iterator(folder, failure)) {
            if (fs::equivalent(entry.path(), device, failure)) links.push_back(entry.path().string());
        }
    }
    std::sort(links.begin(), links.end());
    return links;
}

/// What a device says of itself; nothing if it gives no pictures.
std::optional<VideoDeviceInfo> describe(const fs::path& path) {
    VideoDeviceInfo info;
    info.path = path.string();
    info.serial = serial_of(path.filename().string());
    info.links = links_to(path);
    auto device = open_video_device(info.path);
    if (!device) {
        info.problem = device.error().message;
        return info;
    }
    v4l2_capability said{};
    if ((*device)->control(VIDIOC_QUERYCAP, &said) != 0) return std::nullopt;
    const std::uint32_t capabilities = said.capabilities & V4L2_CAP_DEVICE_CAPS ? said.device_caps : said.capabilities;
    if ((capabilities & V4L2_CAP_VIDEO_CAPTURE) == 0) return std::nullopt;
    const auto text = [](const auto& letters) {
        return std::string(reinterpret_cast<const char*>(letters), strnlen(reinterpret_cast<const char*>(letters), sizeof letters));
    };
    info.card = text(said.card);
    info.bus = text(said.bus_info);
    info.modes = video_modes(**device);
    if (info.modes.empty()) info.problem = "it gives neither YUYV nor MJPEG nor GREY";
    return info;
}

}  // namespace

bool is_video_device(const std::string& source) { return source.starts_with("/dev/") && !source.starts_with("/dev/shm/"); }

Result<std::unique_ptr<VideoDevice>> open_video_device(const std::string& path) {
    const int file = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (file >= 0) return std::unique_ptr<VideoDevice>(std::make_unique<KernelDevice>(file));
    switch (errno) {
        case ENOENT:
        case ENODEV:
        case ENXIO:
            return Error{fmt::format("{}: no such camera: is it plugged in? 'roomfix cameras' lists what is there", path)};
        case EACCES:
        case EPERM:
            return Error{fmt::format("{}: you may not use this camera: sudo usermod -aG video $USER, and log in anew", path)};
        case EBUSY:
            return Error{fmt::format("{}: another program uses this camera: close it", path)};
        default:
            return Error{fmt::format("{}: cannot be opened: {}", path, std::strerror(errno))};
    }
}

const char* name_of(VideoFormat format) {
    switch (format) {
        case VideoFormat::yuyv:
            return "YUYV";
        case VideoFormat::mjpeg:
            return "MJPEG";
        case VideoFormat::grey:
            return "GREY";
    }
    return "";
}

std::vector<VideoMode> video_modes(VideoDevice& device) {
    std::vector<VideoMode> modes;
    v4l2_fmtdesc format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    for (; format.index < most_listed && device.control(VIDIOC_ENUM_FMT, &format) == 0; ++format.index) {
        if (const auto known = format_of(format.pixelformat)) add_modes(device, format.pixelformat, *known, modes);
    }
    const auto pixels = [](const VideoMode& m) { return std::int64_t{m.width} * m.height; };
    std::stable_sort(modes.begin(), modes.end(), [&](const VideoMode& a, const VideoMode& b) { return pixels(a) > pixels(b); });
    return modes;
}

std::optional<VideoMode> choose_mode(const std::vector<VideoMode>& modes, int width, int height, std::optional<double> rate) {
    const double wanted = rate.value_or(often_enough);
    const auto worth = [&](const VideoMode& mode) {
        const bool often = mode.rate == 0 || mode.rate >= 0.99 * wanted;
        const double colour = mode.format == VideoFormat::yuyv ? 2 : mode.format == VideoFormat::mjpeg ? 1 : 0;
        return std::array<double, 3>{often ? 1e6 : mode.rate, static_cast<double>(mode.width) * mode.height, colour};
    };
    std::optional<VideoMode> best;
    for (const VideoMode& mode : modes) {
        if (width > 0 && (mode.width != width || mode.height != height)) continue;
        if (!best || worth(mode) > worth(*best)) best = mode;
    }
    return best;
}

std::vector<VideoDeviceInfo> list_video_devices() {
    std::vector<std::pair<std::int64_t, fs::path>> found;
    std::error_code failure;
    const std::string prefix = "video";
    for (const auto& entry : fs::directory_iterator("/dev", failure)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(prefix)) continue;
        if (const auto number = parse_integer(name.substr(prefix.size()))) found.emplace_back(*number, entry.path());
    }
    std::sort(found.begin(), found.end());
    std::vector<VideoDeviceInfo> devices;
    for (const auto& [number, path] : found) {
        if (auto info = describe(path)) devices.push_back(std::move(*info));
    }
    return devices;
}

}  // namespace roomfix
