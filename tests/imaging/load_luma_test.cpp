#include "roomfix/imaging/load_luma.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace roomfix {
namespace {

cv::Mat picture(int width, int height) {
    cv::Mat image(height, width, CV_8UC3);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) image.at<cv::Vec3b>(y, x) = {static_cast<uchar>(x * 255 / width), static_cast<uchar>(y * 255 / height), 120};
    }
    return image;
}

std::vector<std::uint8_t> jpeg(int width, int height) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", picture(width, height), bytes, {cv::IMWRITE_JPEG_QUALITY, 95});
    return bytes;
}

TEST(DecodeJpeg, LumaIsWhatOpenCvReads) {
    const auto bytes = jpeg(203, 117);
    LumaImage image;
    ASSERT_TRUE(decode_jpeg_luma(bytes, image));
    const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
    ASSERT_EQ(image.width(), expected.cols);
    ASSERT_EQ(image.height(), expected.rows);
    for (int y = 0; y < image.height(); ++y) {
        for (int x = 0; x < image.width(); ++x) ASSERT_NEAR(image.row(y)[x], expected.at<uchar>(y, x), 2);
    }
}

TEST(DecodeJpeg, CropAndScaleGiveThePartAskedFor) {
    const auto bytes = jpeg(203, 117);
    LumaImage whole, part;
    ASSERT_TRUE(decode_jpeg_luma(bytes, whole));
    ASSERT_TRUE(decode_jpeg_luma(bytes, part, {.scale = 1, .crop_x = 37, .crop_y = 21, .crop_width = 90, .crop_height = 50}));
    ASSERT_EQ(part.width(), 90);
    for (int y = 0; y < 50; ++y) {
        for (int x = 0; x < 90; ++x) ASSERT_EQ(part.row(y)[x], whole.row(y + 21)[x + 37]);
    }
    ASSERT_TRUE(decode_jpeg_luma(bytes, part, {.scale = 4}));
    EXPECT_EQ(part.width(), 51);
    EXPECT_EQ(part.height(), 30);
    EXPECT_FALSE(decode_jpeg_luma(bytes, part, {.scale = 1, .crop_x = 150, .crop_y = 0, .crop_width = 90, .crop_height = 50}));
    EXPECT_FALSE(decode_jpeg_luma(bytes, part, {.scale = 3}));
}

TEST(DecodeJpeg, DamageIsAnErrorNotHalfAPicture) {
    auto bytes = jpeg(203, 117);
    LumaImage image;
    for (const std::size_t length : {std::size_t{0}, std::size_t{3}, std::size_t{100}, bytes.size() / 2, bytes.size() - 40}) {
        const auto decoded = decode_luma({bytes.data(), length}, image);
        EXPECT_FALSE(decoded) << length;
    }
    std::fill(bytes.begin() + 700, bytes.begin() + 760, static_cast<std::uint8_t>(0xff));
    (void)decode_luma(bytes, image);  // whatever it says, it must not crash
}

TEST(LoadLuma, PngInColourAndSixteenBitAndTheirErrors) {
    const auto folder = std::filesystem::temp_directory_path() / "roomfix_load_luma_test";
    std::filesystem::create_directories(folder);
    cv::imwrite((folder / "colour.png").string(), picture(40, 30));
    cv::Mat deep(30, 40, CV_16UC1, cv::Scalar(0x8040));
    cv::imwrite((folder / "deep.png").string(), deep);
    const auto colour = load_luma(folder / "colour.png");
    ASSERT_TRUE(colour) << colour.error().message;
    cv::Mat expected;
    cv::cvtColor(picture(40, 30), expected, cv::COLOR_BGR2GRAY);
    EXPECT_EQ(colour->row(11)[17], expected.at<uchar>(11, 17));
    const auto sixteen = load_luma(folder / "deep.png");
    ASSERT_TRUE(sixteen);
    EXPECT_NEAR(sixteen->row(3)[3], 0x80, 1);
    EXPECT_NE(load_luma(folder / "missing.png").error().message.find("missing.png"), std::string::npos);
    EXPECT_FALSE(load_luma(folder));
    std::filesystem::remove_all(folder);
}

TEST(LoadLuma, OnlyKnownFormatsReachTheDecoders) {
    LumaImage image;
    for (const std::string text : {"P3b not quite a PPM", "II*\0 a TIFF", "\x89PN\x47 cut", "DICM", "hello"}) {
        const std::vector<std::uint8_t> bytes(text.begin(), text.end());
        const auto decoded = decode_luma(bytes, image);
        ASSERT_FALSE(decoded) << text;
        EXPECT_NE(decoded.error().message.find("JPEG or PNG"), std::string::npos) << decoded.error().message;
    }
}

}  // namespace
}  // namespace roomfix
