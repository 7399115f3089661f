// Real pictures of a chessboard (OpenCV's samples).
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "data_folder.hpp"
#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/calibrate/lens.hpp"
#include "roomfix/calibrate/plumb_line.hpp"
#include "roomfix/connect/camera_info.hpp"
#include "roomfix/imaging/load_luma.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

const fs::path chessboard_folder = data_folder("chessboard");

std::vector<BoardShot> shots_of(const std::string& side, const Chessboard& board) {
    std::vector<BoardShot> shots;
    for (const auto& entry : fs::directory_iterator(chessboard_folder)) {
        if (entry.path().extension() != ".jpg" || entry.path().filename().string().rfind(side, 0) != 0) continue;
        const auto picture = load_luma(entry.path());
        EXPECT_TRUE(picture);
        if (picture) shots.push_back(find_chessboard(*picture, board, entry.path().filename().string()));
    }
    return shots;
}

/// OpenCV's corners, refined in a window of so many px to each side. By the pictures' names.
constexpr int within_squares = 0;  // a window that stays within the squares
std::map<std::string, std::vector<cv::Point2f>> opencv_corners(const std::string& side, int wanted_window) {
    std::map<std::string, std::vector<cv::Point2f>> all;
    for (const auto& entry : fs::directory_iterator(chessboard_folder)) {
        if (entry.path().extension() != ".jpg" || entry.path().filename().string().rfind(side, 0) != 0) continue;
        const cv::Mat picture = cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE);
        std::vector<cv::Point2f> corners;
        if (!cv::findChessboardCorners(picture, {9, 6}, corners)) continue;
        double least = 1e9;
        for (std::size_t i = 0; i < 54; ++i) {
            if (i % 9 < 8) least = std::min(least, cv::norm(corners[i] - corners[i + 1]));
            if (i < 45) least = std::min(least, cv::norm(corners[i] - corners[i + 9]));
        }
        const int window = wanted_window == within_squares ? std::clamp(static_cast<int>(0.4 * least), 2, 11) : wanted_window;
        cv::cornerSubPix(picture, corners, {window, window}, {-1, -1}, {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
        all[entry.path().filename().string()] = corners;
    }
    return all;
}

/// What OpenCV makes of the same pictures. `released`: OpenCV estimates the board's corners along, too.
struct OpenCvLens {
    double rms = 0;
    Eigen::Matrix<double, 9, 1> numbers;
};
OpenCvLens opencv_lens(const std::string& side, bool released) {
    std::vector<std::vector<cv::Point3f>> places;
    std::vector<std::vector<cv::Point2f>> pixels;
    std::vector<cv::Point3f> board;
    for (int i = 0; i < 54; ++i) board.emplace_back(0.025F * static_cast<float>(i % 9), 0.025F * static_cast<float>(i / 9), 0.0F);
    for (const auto& [name, corners] : opencv_corners(side, within_squares)) {
        places.push_back(board);
        pixels.push_back(corners);
    }
    cv::Mat matrix, distortion, shape;
    std::vector<cv::Mat> rotations, translations;
    constexpr int fixed = 8;  // of the released board: the end of its first row
    OpenCvLens lens;
    lens.rms = released ? cv::calibrateCameraRO(places, pixels, {640, 480}, fixed, matrix, distortion, rotations, translations, shape)
                        : cv::calibrateCamera(places, pixels, {640, 480}, matrix, distortion, rotations, translations);
    lens.numbers << matrix.at<double>(0, 0), matrix.at<double>(1, 1), matrix.at<double>(0, 2), matrix.at<double>(1, 2), distortion.at<double>(0),
        distortion.at<double>(1), distortion.at<double>(2), distortion.at<double>(3), distortion.at<double>(4);
    return lens;
}

TEST(ChessboardData, BothCamerasAreCalibratedBetterThanThePublishedResult) {
    if (!fs::exists(chessboard_folder)) GTEST_SKIP() << chessboard_folder << " is absent: set ROOMFIX_DATA to a chessboard_folder that holds chessboard/";
    const Chessboard board{9, 6, 0.025};
    for (const std::string side : {"left", "right"}) {
        const auto lens = calibrate_lens(shots_of(side, board), 640, 480, board, {.exact_board = true});
        ASSERT_TRUE(lens) << lens.error().message;
        EXPECT_EQ(lens->used(), 13);
        const OpenCvLens opencv = opencv_lens(side, false);
        EXPECT_LT(lens->rms, opencv.rms) << "OpenCV's own on the same shots";
        for (int i = 0; i < 9; ++i) {
            EXPECT_LT(std::abs(lens->model.intrinsics()[i] - opencv.numbers[i]), 2 * std::sqrt(lens->covariance(i, i))) << side << ", number " << i;
        }
        if (side == "right") continue;
        const auto published = load_camera_info(chessboard_folder / "left_intrinsics.yml");
        ASSERT_TRUE(published) << published.error().message;
        EXPECT_LT(lens->rms, 0.3926) << "average reprojection error of the published result";
        // That result rests on one shot whose corners are off by 1.2 px: half a percent of the focal length.
        EXPECT_NEAR(lens->model.fx, published->model.fx, 0.006 * published->model.fx);
        constexpr int p1 = 6;  // 2.7 standard deviations; docs/calibration.md
        for (int i = 0; i < 9; ++i) {
            const double sigma = std::sqrt(lens->covariance(i, i));
            EXPECT_NEAR(lens->model.intrinsics()[i], published->model.intrinsics()[i], (i == p1 ? 3 : 2) * sigma) << "number " << i;
        }
    }
}

TEST(ChessboardData, OnThePublishedResultsOwnCornersWeAgreeWithIt) {
    if (!fs::exists(chessboard_folder)) GTEST_SKIP() << chessboard_folder << " is absent: set ROOMFIX_DATA to a chessboard_folder that holds chessboard/";
    constexpr int published_window = 11;  // px: with it OpenCV gives the published numbers to four digits
    std::vector<BoardShot> shots;
    for (const auto& [name, corners] : opencv_corners("left", published_window)) {
        BoardShot shot{.name = name, .corners = {}, .edge_width = 2, .square_pixels = 30, .refused = {}};
        for (const cv::Point2f& corner : corners) shot.corners.emplace_back(corner.x, corner.y);
        shots.push_back(shot);
    }
    const auto lens = calibrate_lens(shots, 640, 480, {9, 6, 0.025}, {.exact_board = true});
    ASSERT_TRUE(lens) << lens.error().message;
    const auto published = load_camera_info(chessboard_folder / "left_intrinsics.yml");
    ASSERT_TRUE(published) << published.error().message;
    EXPECT_LT(lens->rms, 0.3926) << "average reprojection error of the published result";
    for (int i = 0; i < 9; ++i) {
        EXPECT_LT(std::abs(lens->model.intrinsics()[i] - published->model.intrinsics()[i]), 2 * std::sqrt(lens->covariance(i, i))) << "number " << i;
    }
}

TEST(ChessboardData, BothCamerasMeasureTheSameBoard) {
    if (!fs::exists(chessboard_folder)) GTEST_SKIP() << chessboard_folder << " is absent: set ROOMFIX_DATA to a chessboard_folder that holds chessboard/";
    const Chessboard board{9, 6, 0.025};
    std::vector<Eigen::Matrix3Xd> corners;
    for (const std::string side : {"left", "right"}) {
        const auto lens = calibrate_lens(shots_of(side, board), 640, 480, board);
        ASSERT_TRUE(lens) << lens.error().message;
        EXPECT_EQ(lens->used(), 13);
        EXPECT_LT(lens->rms, 0.5 * opencv_lens(side, false).rms) << "OpenCV's own on the same shots";
        // OpenCV's released board does not bend from shot to shot as this one did (its corners of two right shots are off, besides).
        const OpenCvLens released = opencv_lens(side, true);
        for (int i = 0; side == "left" && i < 9; ++i) {
            EXPECT_LT(std::abs(lens->model.intrinsics()[i] - released.numbers[i]), 3 * std::sqrt(lens->covariance(i, i))) << "number " << i;
        }
        EXPECT_GT(lens->board.print_error(), 5e-5) << "m";
        corners.emplace_back(3, board.corners());
        for (int i = 0; i < board.corners(); ++i) corners.back().col(i) = lens->board.corner(i);
    }
    // Where the board is in its own frame is anybody's guess, and so is its scale.
    const Eigen::Matrix4d moved = Eigen::umeyama(corners[0], corners[1], true);
    const Eigen::Matrix3Xd apart = ((moved.topLeftCorner<3, 3>() * corners[0]).colwise() + moved.topRightCorner<3, 1>()) - corners[1];
    EXPECT_LT(std::sqrt(apart.squaredNorm() / board.corners()), 3e-5) << "m, from other pictures by another camera";
}

TEST(ChessboardData, HalvesOfTheShotsContradictEachOtherLittleMoreThanTheySay) {
    if (!fs::exists(chessboard_folder)) GTEST_SKIP() << chessboard_folder << " is absent: set ROOMFIX_DATA to a chessboard_folder that holds chessboard/";
    const Chessboard board{9, 6, 0.025};
    Random random(3);
    double nees = 0, count = 0;
    for (const std::string side : {"left", "right"}) {
        std::vector<BoardShot> shots = shots_of(side, board);
        for (int split = 0; split < 6; ++split) {
            for (std::size_t i = shots.size() - 1; i > 0; --i) std::swap(shots[i], shots[static_cast<std::size_t>(random.index(static_cast<int>(i) + 1))]);
            const auto first = calibrate_lens({shots.begin(), shots.begin() + 6}, 640, 480, board);
            const auto second = calibrate_lens({shots.begin() + 6, shots.end()}, 640, 480, board);
            ASSERT_TRUE(first && second);
            const Eigen::Matrix<double, 9, 1> apart = (first->model.intrinsics() - second->model.intrinsics()).head<9>();
            const Eigen::Matrix<double, 9, 9> both = (first->covariance + second->covariance).topLeftCorner<9, 9>();
            nees += apart.dot(both.ldlt().solve(apart)) / 9;
            ++count;
        }
    }
    EXPECT_LT(nees / count, 1.9) << "six and seven shots each";
}

TEST(ChessboardData, EdgesOfTheRoomTellTheSameDistortion) {
    if (!fs::exists(chessboard_folder)) GTEST_SKIP() << chessboard_folder << " is absent: set ROOMFIX_DATA to a chessboard_folder that holds chessboard/";
    // k1 as the boards' corners tell. Most long edges are the board's own, which is bent a little.
    for (const auto& [side, k1] : {std::pair{"left", -0.297}, {"right", -0.303}}) {
        std::vector<LongEdge> edges;
        std::size_t number = 0;
        for (const auto& entry : fs::directory_iterator(chessboard_folder)) {
            if (entry.path().extension() != ".jpg" || entry.path().filename().string().rfind(side, 0) != 0) continue;
            const auto picture = load_luma(entry.path());
            ASSERT_TRUE(picture);
            for (LongEdge& edge : long_edges(*picture, number)) edges.push_back(std::move(edge));
            ++number;
        }
        const auto found = straighten(std::move(edges), make_camera_model(640, 480, 535, 535, 319.5, 239.5));
        ASSERT_TRUE(found) << found.error().message;
        EXPECT_LT(found->rms, 0.3 * found->before);
        EXPECT_NEAR(found->model.distortion[0], k1, 0.015) << side;
    }
}

}  // namespace
}  // namespace roomfix
