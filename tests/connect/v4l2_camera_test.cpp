// Cameras of the kernel. There is none in a test: a driver that answers as the kernel's documentation says stands for it.
#include "roomfix/connect/v4l2_camera.hpp"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <deque>
#include <map>
#include <vector>

#include "roomfix/imaging/load_luma.hpp"

namespace roomfix {
namespace {

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
    bool streams = false, unplugged = false, busy = false;
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

constexpr std::uint32_t small_width = 32, small_height = 24;

/// Grey of some brightness, each row with the eight bytes that the driver puts at its end.
std::vector<std::uint8_t> yuyv_picture(std::uint8_t brightness) {
    std::vector<std::uint8_t> bytes;
    for (std::uint32_t y = 0; y < small_height; ++y) {
        for (std::uint32_t x = 0; x < small_width; ++x) bytes.insert(bytes.end(), {brightness, 128});
        bytes.insert(bytes.end(), 8, 255);
    }
    return bytes;
}

Driver ordinary_driver(std::uint32_t fourcc) {
    Driver driver;
    driver.formats = {{fourcc, {{64, 48}, {small_width, small_height}}}};
    driver.controls = {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY},
                       {V4L2_CID_EXPOSURE_ABSOLUTE, 333},
                       {V4L2_CID_GAIN, 0},
                       {V4L2_CID_AUTO_WHITE_BALANCE, 1},
                       {V4L2_CID_WHITE_BALANCE_TEMPERATURE, 4000}};
    return driver;
}

LiveSettings small_pictures() {
    LiveSettings settings;
    settings.width = small_width;
    settings.height = small_height;
    settings.capture.exposure = 0.008;
    return settings;
}

TEST(V4l2Camera, GivesTheNewestWholePictureAndTheMiddleOfItsExposure) {
    Driver driver = ordinary_driver(V4L2_PIX_FMT_YUYV);
    auto source = start_v4l2_camera(std::make_unique<DriverDevice>(driver), "/dev/video7", small_pictures());
    ASSERT_TRUE(source) << source.error().message;
    EXPECT_TRUE(driver.streams);
    EXPECT_EQ(driver.queued.size(), 3U);
    for (int round = 0; round < 5; ++round) {
        driver.pictures = {{yuyv_picture(50), 0.1}, {yuyv_picture(126), 0.05}};
        driver.pictures.push_back({yuyv_picture(200), 0.01, V4L2_BUF_FLAG_ERROR});
        SourceFrame frame;
        const Nanoseconds before = system_now();
        const auto more = (*source)->next(frame);
        ASSERT_TRUE(more && *more);
        // The exposure began 0.05 s ago and took 8 ms.
        EXPECT_GE(to_seconds(frame.time - before), -0.046 - 1e-3);
        EXPECT_LE(to_seconds(frame.time - system_now()), -0.046 + 1e-3);
        EXPECT_LE(frame.time_sigma, 0.002);
        EXPECT_EQ(frame.image.width(), 32);
        EXPECT_EQ(frame.image.row(23)[31], 128);  // (126 - 16) * 255 / 219
        EXPECT_EQ(frame.colour.channels, 1);      // there is no colour in it
        EXPECT_EQ((*source)->passed_over(), round + 1);
        EXPECT_EQ(driver.queued.size(), 2U);  // the third is looked at
    }
    EXPECT_NE((*source)->note().find("sets its white_balance by itself"), std::string::npos) << (*source)->note();
    EXPECT_EQ((*source)->note().find("exposure"), std::string::npos) << (*source)->note();
    driver.unplugged = true;
    SourceFrame frame;
    const auto gone = (*source)->next(frame);
    ASSERT_FALSE(gone);
    EXPECT_NE(gone.error().message.find("/dev/video7: the camera was unplugged"), std::string::npos);
    source->reset();
}

TEST(V4l2Camera, JpegsAreKeptAsTheyCame) {
    Driver driver = ordinary_driver(V4L2_PIX_FMT_MJPEG);
    auto source = start_v4l2_camera(std::make_unique<DriverDevice>(driver), "/dev/video7", small_pictures());
    ASSERT_TRUE(source) << source.error().message;
    LumaImage picture(32, 24);
    for (int y = 0; y < 24; ++y) std::memset(picture.row(y), 90, 32);
    const auto jpeg = encode_jpeg(picture, 90);
    driver.pictures = {{jpeg}};
    SourceFrame frame;
    ASSERT_TRUE((*source)->next(frame));
    EXPECT_EQ(frame.encoded, jpeg);
    EXPECT_NEAR(frame.image.row(5)[5], 90, 1);
    driver.pictures = {{{jpeg.begin(), jpeg.begin() + 100}}};
    EXPECT_FALSE((*source)->next(frame));
}

TEST(V4l2Camera, GreyPicturesAndThoseThatWereCutOff) {
    Driver driver = ordinary_driver(V4L2_PIX_FMT_GREY);
    auto source = start_v4l2_camera(std::make_unique<DriverDevice>(driver), "/dev/video7", small_pictures());
    ASSERT_TRUE(source) << source.error().message;
    driver.pictures = {{std::vector<std::uint8_t>((2 * small_width + 8) * small_height, 77)}};
    SourceFrame frame;
    ASSERT_TRUE((*source)->next(frame));
    EXPECT_EQ(frame.image.row(23)[31], 77);
    driver.pictures = {{std::vector<std::uint8_t>(100, 77)}};
    const auto cut = (*source)->next(frame);
    ASSERT_FALSE(cut);
    EXPECT_NE(cut.error().message.find("cut off"), std::string::npos);
}

TEST(V4l2Camera, WhatCannotBeHadSaysWhatToDo) {
    Driver driver = ordinary_driver(V4L2_PIX_FMT_YUYV);
    LiveSettings settings = small_pictures();
    settings.width = 33;
    const auto wrong_size = start_v4l2_camera(std::make_unique<DriverDevice>(driver), "/dev/video7", settings);
    ASSERT_FALSE(wrong_size);
    EXPECT_NE(wrong_size.error().message.find("no pictures of 33 x 24"), std::string::npos);
    driver.busy = true;
    const auto busy = start_v4l2_camera(std::make_unique<DriverDevice>(driver), "/dev/video7", small_pictures());
    ASSERT_FALSE(busy);
    EXPECT_NE(busy.error().message.find("another program uses this camera"), std::string::npos);
    Driver none = ordinary_driver(V4L2_PIX_FMT_H264);
    EXPECT_FALSE(start_v4l2_camera(std::make_unique<DriverDevice>(none), "/dev/video7", small_pictures()));
    const auto absent = open_source("/dev/video77");
    ASSERT_FALSE(absent);
    EXPECT_NE(absent.error().message.find("is it plugged in?"), std::string::npos);
}

TEST(V4l2Camera, TellsWhichSettingsAreNotAsAskedFor) {
    Driver driver = ordinary_driver(V4L2_PIX_FMT_YUYV);
    DriverDevice device(driver);
    CaptureSettings wanted;
    EXPECT_FALSE(apply_settings(device, wanted).exposure);  // the camera sets it
    wanted.exposure = 0.005;
    wanted.gain = 12;
    wanted.white_balance = 5000;
    const AppliedSettings applied = apply_settings(device, wanted);
    EXPECT_EQ(applied.exposure, 0.005);
    EXPECT_EQ(driver.controls[V4L2_CID_EXPOSURE_AUTO], V4L2_EXPOSURE_MANUAL);
    EXPECT_EQ(driver.controls[V4L2_CID_EXPOSURE_ABSOLUTE], 50);
    EXPECT_EQ(driver.controls[V4L2_CID_AUTO_WHITE_BALANCE], 0);
    EXPECT_EQ(applied.told, "gain is 10 and not 12");
    driver.controls.erase(V4L2_CID_GAIN);
    EXPECT_EQ(apply_settings(device, wanted).told, "the camera does not take gain = 12");
}

TEST(V4l2Camera, ChoosesUnpackedPicturesWhereTheyComeOftenEnough) {
    const std::vector<VideoMode> modes = {{VideoFormat::mjpeg, 1920, 1080, 30},
                                          {VideoFormat::yuyv, 1920, 1080, 5},
                                          {VideoFormat::yuyv, 640, 480, 30},
                                          {VideoFormat::mjpeg, 640, 480, 60},
                                          {VideoFormat::grey, 640, 480, 60}};
    EXPECT_EQ(choose_mode(modes, 1920, 1080, std::nullopt), modes[0]);
    EXPECT_EQ(choose_mode(modes, 1920, 1080, 5), modes[1]);
    EXPECT_EQ(choose_mode(modes, 640, 480, std::nullopt), modes[2]);
    EXPECT_EQ(choose_mode(modes, 640, 480, 60), modes[3]);
    EXPECT_EQ(choose_mode(modes, 0, 0, std::nullopt), modes[0]);
    EXPECT_FALSE(choose_mode(modes, 800, 600, std::nullopt));
}

TEST(V4l2Camera, TimeStampsOfAllKindsBecomeTheMiddleOfTheExposure) {
    const ClockPair now{1000, 1'800'000'000'000'000'000};
    const auto after_now = [&](const StampedTime& t) { return to_seconds(t.time - now.system); };
    const StampedTime start = middle_of_exposure({999.9, true, true}, now, 0.01, 0.04);
    EXPECT_NEAR(after_now(start), -0.095, 1e-6);
    EXPECT_NEAR(start.sigma, 0.001, 1e-9);
    // An exposure of unknown length, of which only the end of reading out is known: anywhere within the interval.
    const StampedTime end = middle_of_exposure({999.9, true, false}, now, std::nullopt, 0.04);
    EXPECT_NEAR(after_now(end), -0.13, 1e-6);
    EXPECT_GT(end.sigma, 0.01);
    for (const BufferStamp& strange : {BufferStamp{999.9, false, true}, BufferStamp{1e6, true, true}, BufferStamp{3, true, true}}) {
        EXPECT_EQ(middle_of_exposure(strange, now, 0.01, 0.04).time, now.system);
        EXPECT_GT(middle_of_exposure(strange, now, 0.01, 0.04).sigma, 0.02);
    }
}

}  // namespace
}  // namespace roomfix
