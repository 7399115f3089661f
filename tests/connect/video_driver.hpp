// A driver that answers as the kernel's documentation says, where a test has no camera.
#pragma once

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "roomfix/connect/video_device.hpp"

namespace roomfix {

/// What a driver has, and what happened to it.
struct Driver {
    struct Picture {
        std::vector<std::uint8_t> bytes;
        double age = 0.01;  // s since the start of its exposure
        std::uint32_t flags = 0;
    };
    std::vector<std::pair<std::uint32_t, std::vector<std::pair<std::uint32_t, std::uint32_t>>>> formats;  // and their sizes
    std::map<std::uint32_t, std::int32_t> controls;
    std::deque<Picture> pictures;  // that wait to be put into buffers
    std::deque<std::uint32_t> queued;
    std::vector<std::vector<std::uint8_t>> memory;
    bool streams = false, unplugged = false, busy = false, any_size = false;
};

template <class T>
T& as(void* argument) {
    return *static_cast<T*>(argument);
}

class DriverDevice final : public VideoDevice {
public:
    explicit DriverDevice(Driver& driver) : driver_(driver) {}

    int control(unsigned long request, void* argument) override {
        if (driver_.unplugged) return ENODEV;
        switch (request) {
            case VIDIOC_ENUM_FMT:
                return list_format(as<v4l2_fmtdesc>(argument));
            case VIDIOC_ENUM_FRAMESIZES:
                return list_size(as<v4l2_frmsizeenum>(argument));
            case VIDIOC_ENUM_FRAMEINTERVALS: {
                auto& interval = as<v4l2_frmivalenum>(argument);
                if (interval.index > 0) return EINVAL;
                interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
                interval.discrete = {1, interval.pixel_format == V4L2_PIX_FMT_MJPEG ? 30U : 5U};
                return 0;
            }
            case VIDIOC_S_FMT:
                if (driver_.busy) return EBUSY;
                as<v4l2_format>(argument).fmt.pix.bytesperline = as<v4l2_format>(argument).fmt.pix.width * 2 + 8;
                return 0;
            case VIDIOC_S_PARM:
                return 0;
            case VIDIOC_S_CTRL:
                return set(as<v4l2_control>(argument));
            case VIDIOC_G_CTRL:
                return get(as<v4l2_control>(argument));
            case VIDIOC_REQBUFS:
                as<v4l2_requestbuffers>(argument).count = 3;
                driver_.memory.assign(3, std::vector<std::uint8_t>(1 << 16));
                return 0;
            case VIDIOC_QUERYBUF:
                as<v4l2_buffer>(argument).length = 1 << 16;
                as<v4l2_buffer>(argument).m.offset = as<v4l2_buffer>(argument).index << 16;
                return 0;
            case VIDIOC_QBUF:
                driver_.queued.push_back(as<v4l2_buffer>(argument).index);
                return 0;
            case VIDIOC_DQBUF:
                return give(as<v4l2_buffer>(argument));
            case VIDIOC_STREAMON:
                driver_.streams = true;
                return 0;
            case VIDIOC_STREAMOFF:
                driver_.streams = false;
                return 0;
            default:
                return ENOTTY;
        }
    }
    std::span<std::uint8_t> map(std::size_t, std::int64_t offset) override { return driver_.memory[static_cast<std::size_t>(offset >> 16)]; }
    bool wait(double) override { return driver_.unplugged || !driver_.pictures.empty(); }

private:
    int list_format(v4l2_fmtdesc& format) const {
        if (format.index >= driver_.formats.size()) return EINVAL;
        format.pixelformat = driver_.formats[format.index].first;
        return 0;
    }
    int list_size(v4l2_frmsizeenum& size) const {
        if (driver_.any_size) {
            size.type = V4L2_FRMSIZE_TYPE_STEPWISE;
            size.stepwise = {16, 1456, 8, 16, 1088, 8};
            return size.index == 0 ? 0 : EINVAL;
        }
        for (const auto& [fourcc, sizes] : driver_.formats) {
            if (fourcc != size.pixel_format || size.index >= sizes.size()) continue;
            size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
            size.discrete = {sizes[size.index].first, sizes[size.index].second};
            return 0;
        }
        return EINVAL;
    }
    int set(const v4l2_control& control) {
        if (!driver_.controls.contains(control.id)) return EINVAL;
        driver_.controls[control.id] = control.id == V4L2_CID_GAIN ? std::min(control.value, 10) : control.value;
        return 0;
    }
    int get(v4l2_control& control) const {
        const auto found = driver_.controls.find(control.id);
        if (found == driver_.controls.end()) return EINVAL;
        control.value = found->second;
        return 0;
    }
    int give(v4l2_buffer& buffer) {
        if (driver_.pictures.empty() || driver_.queued.empty()) return EAGAIN;
        const Driver::Picture picture = driver_.pictures.front();
        driver_.pictures.pop_front();
        buffer.index = driver_.queued.front();
        driver_.queued.pop_front();
        std::copy(picture.bytes.begin(), picture.bytes.end(), driver_.memory[buffer.index].begin());
        buffer.bytesused = static_cast<std::uint32_t>(picture.bytes.size());
        buffer.flags = picture.flags | V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
        timespec now{};
        clock_gettime(CLOCK_MONOTONIC, &now);
        const double taken = static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec) - picture.age;
        buffer.timestamp.tv_sec = static_cast<time_t>(taken);
        buffer.timestamp.tv_usec = static_cast<suseconds_t>(1e6 * (taken - std::floor(taken)));
        return 0;
    }
    Driver& driver_;
};

}  // namespace roomfix
