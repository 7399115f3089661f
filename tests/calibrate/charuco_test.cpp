#include "roomfix/calibrate/charuco.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "roomfix/calibrate/lens.hpp"
#include "roomfix/evaluate/simulated_boards.hpp"

namespace roomfix {
namespace {

Chessboard marked_board(int columns, int rows) { return {columns, rows, 0.03, BoardMarkers{"DICT_5X5_250", 0.022}}; }

CameraModel wide_camera() { return make_camera_model(640, 480, 420, 421, 322, 238, {-0.25, 0.06, 0.0005, -0.0004, 0}); }

/// A board close before the camera, so that its rim is out of sight.
Eigen::Isometry3d pose_before(double distance, double turn, const Chessboard& board) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = exponential_rotation(Eigen::Vector3d(0.25, -0.3, turn));
    const Eigen::Vector2d middle = 0.5 * board.corner(board.corners() - 1);
    pose.translation() = Eigen::Vector3d(0, 0, distance) - pose.linear() * Eigen::Vector3d(middle.x(), middle.y(), 0);
    return pose;
}

struct Charuco : testing::Test {
    void SetUp() override {
        if (!can_read_charuco()) GTEST_SKIP() << "built without OpenCV's aruco module";
    }
};

TEST_F(Charuco, APartOfTheBoardIsEnoughAndEachCornerIsTheRightOne) {
    const CameraModel camera = wide_camera();
    PlanePictures pictures(camera, {}, 3);
    for (const auto& [columns, rows, old] : {std::tuple{9, 6, false}, {8, 7, false}, {8, 7, true}}) {
        const Chessboard board = marked_board(columns, rows);
        LumaImage picture;
        for (const double turn : {0.0, 0.4, 3.0}) {
            const Eigen::Isometry3d pose = pose_before(0.16, turn, board);
            pictures.render(pattern_of(board, old), pose, 1, picture);
            const BoardShot shot = find_charuco(picture, board, "shot");
            ASSERT_TRUE(shot.refused.empty()) << shot.refused;
            EXPECT_LT(shot.corners.size(), static_cast<std::size_t>(board.corners())) << "some are out of sight";
            for (std::size_t i = 0; i < shot.corners.size(); ++i) {
                const Eigen::Vector2d at = board.corner(shot.number(i));
                const auto truth = project(camera, pose * Eigen::Vector3d(at.x(), at.y(), 0));
                ASSERT_TRUE(truth);
                EXPECT_LT((shot.corners[i] - *truth).norm(), 0.15) << columns << "x" << rows << " corner " << shot.number(i);
            }
        }
    }
}

TEST_F(Charuco, GivesALens) {
    const CameraModel camera = wide_camera();
    const Chessboard board = marked_board(9, 6);
    PlanePictures pictures(camera, {}, 4);
    Random random(6);
    std::vector<BoardShot> shots;
    LumaImage picture;
    const FlatPattern pattern = pattern_of(board);
    for (const Eigen::Isometry3d& pose : board_poses(camera, board.corner(board.corners() - 1), 15, random)) {
        pictures.render(pattern, pose, shots.size(), picture);
        shots.push_back(find_board(picture, board, std::to_string(shots.size())));
    }
    for (int i = 0; i < 5; ++i) {  // and some from so near that the board fills the picture
        pictures.render(pattern, pose_before(0.14 + 0.02 * i, 0.2 * i, board), shots.size(), picture);
        shots.push_back(find_board(picture, board, std::to_string(shots.size())));
    }
    const auto lens = calibrate_lens(shots, 640, 480, board);
    ASSERT_TRUE(lens) << lens.error().message;
    std::string refused;
    for (const BoardShot& s : lens->shots) refused += s.refused.empty() ? "" : "\n" + s.refused;
    EXPECT_GT(lens->used(), 12) << refused;
    for (int i = 0; i < 4; ++i) {
        EXPECT_LT(std::abs(lens->model.intrinsics()[i] - camera.intrinsics()[i]), 4 * std::sqrt(lens->covariance(i, i))) << "number " << i;
        EXPECT_LT(std::sqrt(lens->covariance(i, i)), 1.0);
    }
}

TEST_F(Charuco, SaysWhatIsWrong) {
    const Chessboard board = marked_board(9, 6);
    Chessboard other = board;
    other.markers->dictionary = "DICT_9X9_5";
    EXPECT_NE(check_charuco(other).error().message.find("DICT_4X4_50"), std::string::npos) << "the choice is named";
    other = board;
    other.markers->size = 0.03;
    EXPECT_NE(check_charuco(other).error().message.find("do not fit"), std::string::npos);
    other = marked_board(29, 29);
    EXPECT_NE(check_charuco(other).error().message.find("450 markers"), std::string::npos);
    PlanePictures pictures(wide_camera(), {}, 5);
    LumaImage picture;
    pictures.render(pattern_of(board), pose_before(0.5, 0.1, board), 0, picture);
    EXPECT_FALSE(find_charuco(picture, marked_board(7, 9), "wrong size").refused.empty());
    pictures.render(pattern_of({9, 6, 0.03}), pose_before(0.5, 0.1, board), 0, picture);
    EXPECT_NE(find_charuco(picture, board, "plain").refused.find("no markers"), std::string::npos);
    pictures.render(pattern_of(board), pose_before(0.5, 0.1, board), 0, picture);
    EXPECT_TRUE(find_charuco(picture, board, "right").refused.empty());
    for (int y = 0; y < picture.height(); ++y) std::reverse(picture.row(y), picture.row(y) + picture.width());
    EXPECT_FALSE(find_charuco(picture, board, "in a mirror").refused.empty());
    EXPECT_NE(board_svg(board).find("DICT_5X5_250"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
