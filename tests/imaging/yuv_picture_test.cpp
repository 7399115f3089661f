#include "roomfix/imaging/yuv_picture.hpp"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/imgproc.hpp>

#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/imaging/y4m.hpp"

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

/// A picture of 5 x 3 pixels with colours at any places, of other values everywhere.
struct SmallYuv {
    std::vector<std::uint8_t> bytes = std::vector<std::uint8_t>(64);
    YuvView view;
    SmallYuv(int shift_x, int shift_y, bool full_range) {
        for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(20 + 3 * i);
        view = {bytes.data(), bytes.data() + 20, bytes.data() + 40, 5, 3, 5, 5, 1, 1, shift_x, shift_y, full_range};
    }
};

TEST(YuvPicture, AFileHasAllOfIt) {
    for (const auto& [x, y] : {std::pair{1, 1}, {1, 0}, {0, 0}, {2, 0}, {0, 1}}) {
        for (const bool full_range : {false, true}) {
            const SmallYuv picture(x, y, full_range);
            const auto file = encode_y4m(picture.view);
            ASSERT_TRUE(file) << file.error().message;
            LumaImage luma, read_luma;
            ColourImage colour, read_colour;
            luma_from_yuv(picture.view, luma);
            colour_from_yuv(picture.view, colour);
            ASSERT_TRUE(decode_picture(*file, read_luma, read_colour));
            ASSERT_EQ(read_luma.width(), 5);
            ASSERT_EQ(read_luma.height(), 3);
            for (int row = 0; row < 3; ++row) EXPECT_TRUE(std::equal(luma.row(row), luma.row(row) + 5, read_luma.row(row)));
            EXPECT_EQ(read_colour.channels, 3);
            EXPECT_EQ(read_colour.values, colour.values);
            for (std::size_t size = 0; size < file->size(); ++size) EXPECT_FALSE(decode_luma({file->data(), size}, read_luma)) << size;
        }
    }
    EXPECT_FALSE(encode_y4m(SmallYuv(3, 1, false).view));
    const std::string_view deep = "YUV4MPEG2 W2 H2 C420p10\nFRAME\n";
    EXPECT_FALSE(y4m_view({reinterpret_cast<const std::uint8_t*>(deep.data()), deep.size()}));
}

TEST(YuvPicture, AJpegOfItLooksTheSame) {
    cv::Mat planes, bgr;
    cv::cvtColor(colourful(), planes, cv::COLOR_BGR2YUV_I420);
    YuvView view;
    view.width = yuv_width;
    view.height = yuv_height;
    view.y = planes.data;
    view.u = view.y + yuv_width * yuv_height;
    view.v = view.u + yuv_width * yuv_height / 4;
    view.y_stride = yuv_width;
    view.colour_stride = yuv_width / 2;
    LumaImage luma, read_luma;
    ColourImage colour, read_colour;
    luma_from_yuv(view, luma);
    colour_from_yuv(view, colour);
    ASSERT_TRUE(decode_picture(encode_jpeg(view, 95), read_luma, read_colour));
    ASSERT_EQ(read_colour.values.size(), colour.values.size());
    int luma_off = 0, colour_off = 0;
    for (int y = 0; y < yuv_height; ++y) {
        for (int x = 0; x < yuv_width; ++x) luma_off = std::max(luma_off, std::abs(luma.row(y)[x] - read_luma.row(y)[x]));
    }
    for (std::size_t i = 0; i < colour.values.size(); ++i) colour_off = std::max(colour_off, std::abs(colour.values[i] - read_colour.values[i]));
    EXPECT_LE(luma_off, 4);
    EXPECT_LE(colour_off, 12);
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
