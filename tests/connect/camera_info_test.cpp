#include "roomfix/connect/camera_info.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

TEST(CameraInfo, ReadsBackAllKindsOfLenses) {
    for (const Distortion kind : {Distortion::plumb_bob, Distortion::rational_polynomial, Distortion::equidistant}) {
        const CameraInfo info{"hall", make_camera_model(640, 480, 533.25, 535.5, 327.125, 235, {-0.2, 0.05, 1e-7, -0.0006}, kind)};
        const auto again = parse_camera_info(camera_info_text(info));
        ASSERT_TRUE(again) << again.error().message;
        EXPECT_EQ(again->name, "hall");
        EXPECT_EQ(again->model.kind, kind);
        EXPECT_EQ(again->model.intrinsics(), info.model.intrinsics());
    }
}

TEST(CameraInfo, ReadsWhatOpenCVWrites) {
    const auto info = parse_camera_info(
        "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
        "   data: [ 5.3591573396163199e+02, 0., 3.4228315473308373e+02, 0.,\n       5.3591573396163199e+02, 2.e+02, 0., 0., 1. ]\n"
        "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ -2.6e-01, 0., 1.e-03, 0., 0. ]\n");
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->model.fx, 535.91573396163199);
    EXPECT_EQ(info->model.cy, 200);
    EXPECT_EQ(info->model.distortion[2], 1e-3);
}

TEST(CameraInfo, NamesTheKeyThatIsWrong) {
    const std::string good = camera_info_text({"hall", make_camera_model(640, 480, 533, 535, 327, 235)});
    const auto expect_error = [](const std::string& text, const char* words) {
        const auto info = parse_camera_info(text);
        ASSERT_FALSE(info) << text;
        EXPECT_NE(info.error().message.find(words), std::string::npos) << info.error().message;
    };
    const auto with = [&](const std::string& before, const std::string& after) {
        std::string text = good;
        return text.replace(text.find(before), before.size(), after);
    };
    expect_error("", "no keys");
    expect_error("a: [", "not valid YAML");
    expect_error(with("image_width: 640", "image_width: 0"), "image_width");
    expect_error(with("image_width: 640", "image_width: 640.5"), "image_width");
    expect_error(with("camera_matrix:", "matrix:"), "camera_matrix.data is missing");
    expect_error(with("[533,", "[x,"), "no number");
    expect_error(with("[533,", "[-533,"), "positive focal lengths");
    expect_error(with("[533, 0,", "[533, 2,"), "skew");
    expect_error(with("plumb_bob", "thin_prism"), "'thin_prism'");
    expect_error(with("data: [0, 0, 0, 0, 0]", "data: [0, 0, 0, 0, 0, 0]"), "6 distortion coefficients");
}

}  // namespace
}  // namespace roomfix
