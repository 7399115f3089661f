// Cameras of the kernel, behind a driver of ours.
#include "roomfix/connect/v4l2_camera.hpp"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cstring>
#include <vector>

#include "roomfix/imaging/load_luma.hpp"
#include "video_driver.hpp"

namespace roomfix {
namespace {

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
        EXPECT_LE(frame.time_error.sigma, 0.002);
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

TEST(V4l2Camera, OfACameraThatGivesAnySizeTheUsualOnesAreListed) {
    Driver driver = ordinary_driver(V4L2_PIX_FMT_JPEG);
    driver.any_size = true;
    DriverDevice device(driver);
    std::vector<std::pair<int, int>> sizes;
    for (const VideoMode& mode : video_modes(device)) {
        EXPECT_EQ(mode.format, VideoFormat::mjpeg);
        EXPECT_EQ(mode.fourcc, V4L2_PIX_FMT_JPEG);
        sizes.emplace_back(mode.width, mode.height);
    }
    EXPECT_EQ(sizes, (std::vector<std::pair<int, int>>{{1456, 1088}, {1280, 960}, {1280, 720}, {1024, 768}, {800, 600}, {640, 480}, {320, 240}}));
}

TEST(V4l2Camera, ARawPictureIsKeptWithAllItsColours) {
    Driver driver = ordinary_driver(V4L2_PIX_FMT_YUYV);
    auto source = start_v4l2_camera(std::make_unique<DriverDevice>(driver), "/dev/video7", small_pictures());
    ASSERT_TRUE(source) << source.error().message;
    SourceFrame frame;
    driver.pictures = {{yuyv_picture(50), 0.01}};
    ASSERT_TRUE((*source)->next(frame));
    EXPECT_FALSE(frame.file);  // nobody wants it
    (*source)->keep_files();
    std::vector<std::uint8_t> bytes = yuyv_picture(90);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i % 2 ? 60 + i % 91 : 30 + i % 200);
    driver.pictures = {{bytes, 0.01}};
    ASSERT_TRUE((*source)->next(frame));
    ASSERT_TRUE(frame.file);
    const auto file = frame.file();
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->ending, "y4m");
    LumaImage grey;
    ColourImage colour;
    ASSERT_TRUE(decode_picture(file->bytes, grey, colour));
    ASSERT_EQ(grey.width(), frame.image.width());
    for (int y = 0; y < grey.height(); ++y) EXPECT_EQ(0, std::memcmp(grey.row(y), frame.image.row(y), static_cast<std::size_t>(grey.width())));
    EXPECT_EQ(colour.channels, 3);
    EXPECT_EQ(colour.values, frame.colour.values);
}

TEST(V4l2Camera, TimeStampsOfAllKindsBecomeTheMiddleOfTheExposure) {
    const ClockPair now{1000, 1'800'000'000'000'000'000};
    const auto after_now = [&](const StampedTime& t) { return to_seconds(t.time - now.system); };
    const StampedTime start = middle_of_exposure({999.9, true, true}, now, 0.01, 0.04);
    EXPECT_NEAR(after_now(start), -0.095, 1e-6);
    EXPECT_NEAR(start.error.sigma, 0.001, 1e-9);
    // An exposure of unknown length, of which only the end of reading out is known: anywhere within the interval.
    const StampedTime end = middle_of_exposure({999.9, true, false}, now, std::nullopt, 0.04);
    EXPECT_NEAR(after_now(end), -0.13, 1e-6);
    EXPECT_GT(end.error.sigma, 0.01);
    // Rows that are exposed one after another: the middle one is meant.
    EXPECT_NEAR(after_now(middle_of_exposure({999.9, true, true}, now, 0.01, 0.04, 0.02)), -0.085, 1e-6);
    const StampedTime read_out = middle_of_exposure({999.9, true, false}, now, 0.01, 0.04, 0.02);
    EXPECT_NEAR(after_now(read_out), -0.115, 1e-6);
    EXPECT_NEAR(read_out.error.sigma, 0.001, 1e-9);
    for (const BufferStamp& strange : {BufferStamp{999.9, false, true}, BufferStamp{1e6, true, true}, BufferStamp{3, true, true}}) {
        EXPECT_EQ(middle_of_exposure(strange, now, 0.01, 0.04).time, now.system);
        EXPECT_GT(middle_of_exposure(strange, now, 0.01, 0.04).error.sigma, 0.02);
    }
}

}  // namespace
}  // namespace roomfix
