#include "roomfix/imaging/yuv_picture.hpp"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/imgproc.hpp>

#include "roomfix/imaging/load_luma.hpp"

namespace roomfix {
namespace {

constexpr int yuv_width = 1300, yuv_height = 100;

/// Smooth colours all over: black to white along the rows, others down the columns.
cv::Mat colourful() {
    cv::Mat picture(yuv_height, yuv_width, CV_8UC3);
    for (int y = 0; y < yuv_height; ++y) {
        for (int x = 0; x < yuv_width; ++x) {
            picture.at<cv::Vec3b>(y, x) =
                cv::Vec3b(static_cast<std::uint8_t>(x * 255 / yuv_width), static_cast<std::uint8_t>(y * 2), static_cast<std::uint8_t>(255 - x / 6));
        }
    }
    return picture;
}

void expect_like_opencv(const YuvView& view, const cv::Mat& bgr) {
    LumaImage luma, expected_luma;
    ColourImage colour, expected_colour;
    luma_from_yuv(view, luma);
    colour_from_yuv(view, colour);
    ASSERT_TRUE(luma_from_mat(bgr, expected_luma));
    ASSERT_TRUE(colour_from_mat(bgr, expected_colour));
    ASSERT_EQ(luma.width(), yuv_width);
    ASSERT_EQ(colour.width, expected_colour.width);
    ASSERT_EQ(colour.height, expected_colour.height);
    ASSERT_EQ(colour.channels, expected_colour.channels);
    int luma_off = 0, colour_off = 0;
    for (int y = 0; y < yuv_height; ++y) {
        for (int x = 0; x < yuv_width; ++x) luma_off = std::max(luma_off, std::abs(luma.row(y)[x] - expected_luma.row(y)[x]));
    }
    for (std::size_t i = 0; i < colour.values.size(); ++i) colour_off = std::max(colour_off, std::abs(colour.values[i] - expected_colour.values[i]));
    EXPECT_LE(luma_off, 2);
    EXPECT_LE(colour_off, 4);
}

TEST(YuvPicture, VideoOfThreePlanesIsWhatOpenCvMakesOfIt) {
    cv::Mat planes, bgr;
    cv::cvtColor(colourful(), planes, cv::COLOR_BGR2YUV_I420);
    cv::cvtColor(planes, bgr, cv::COLOR_YUV2BGR_I420);
    YuvView view;
    view.width = yuv_width;
    view.height = yuv_height;
    view.y = planes.data;
    view.u = view.y + yuv_width * yuv_height;
    view.v = view.u + yuv_width * yuv_height / 4;
    view.y_stride = yuv_width;
    view.colour_stride = yuv_width / 2;
    expect_like_opencv(view, bgr);
}

TEST(YuvPicture, PackedPicturesAreWhatOpenCvMakesOfThem) {
    cv::Mat planes;
    cv::cvtColor(colourful(), planes, cv::COLOR_BGR2YUV_I420);
    cv::Mat packed(yuv_height, yuv_width, CV_8UC2);
    for (int y = 0; y < yuv_height; ++y) {
        for (int x = 0; x < yuv_width; ++x) {
            const std::uint8_t* chroma = planes.data + yuv_width * yuv_height + (x % 2) * yuv_width * yuv_height / 4;
            packed.at<cv::Vec2b>(y, x) = cv::Vec2b(planes.at<std::uint8_t>(y, x), chroma[(y / 2) * (yuv_width / 2) + x / 2]);
        }
    }
    cv::Mat bgr;
    cv::cvtColor(packed, bgr, cv::COLOR_YUV2BGR_YUYV);
    expect_like_opencv(yuyv_view(packed.data, yuv_width, yuv_height, 2 * yuv_width), bgr);
}

TEST(YuvPicture, FullRangeIsKeptAndWithoutColourItIsGrey) {
    std::array<std::uint8_t, 256> ramp{};
    for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<std::uint8_t>(i);
    YuvView view;
    view.width = 256;
    view.height = 1;
    view.y = ramp.data();
    view.y_stride = 256;
    view.full_range = true;
    LumaImage luma;
    ColourImage colour;
    luma_from_yuv(view, luma);
    colour_from_yuv(view, colour);
    EXPECT_EQ(colour.channels, 1);
    for (int i = 0; i < 256; ++i) {
        EXPECT_EQ(luma.row(0)[i], i);
        EXPECT_EQ(colour.values[static_cast<std::size_t>(i)], i);
    }
    view.full_range = false;
    luma_from_yuv(view, luma);
    EXPECT_EQ(luma.row(0)[16], 0);
    EXPECT_EQ(luma.row(0)[235], 255);
    EXPECT_EQ(luma.row(0)[255], 255);
    EXPECT_EQ(luma.row(0)[0], 0);
}

}  // namespace
}  // namespace roomfix
