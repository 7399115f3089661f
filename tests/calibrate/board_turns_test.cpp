#include "roomfix/calibrate/board_turns.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "roomfix/calibrate/lens.hpp"
#include "roomfix/calibrate/lens_report.hpp"
#include "roomfix/evaluate/simulated_boards.hpp"

namespace roomfix {
namespace {

CameraModel plain_camera() { return make_camera_model(640, 480, 533, 535, 327, 235, {-0.28, 0.08, 0.001, -0.0006, 0.01}); }

/// Shots as a finder gives them that does not see which way up the board is.
std::vector<BoardShot> counted_at_will(const std::vector<BoardShot>& shots, const Chessboard& board, Random& random) {
    const int ways = 4 / quarter_turns_alike(board);
    std::vector<BoardShot> counted;
    for (const BoardShot& shot : shots) counted.push_back(counted_turned(shot, board, static_cast<int>(random.uniform(0, ways))));
    return counted;
}

TEST(BoardTurns, GoWithThePattern) {
    EXPECT_EQ(quarter_turns_alike({9, 6}), 4);
    EXPECT_EQ(quarter_turns_alike({8, 6}), 2);
    EXPECT_EQ(quarter_turns_alike({9, 7}), 2);
    EXPECT_EQ(quarter_turns_alike({7, 7}), 1);
    EXPECT_EQ(quarter_turns_alike({7, 7, 0.02, BoardMarkers{"DICT_5X5_250", 0.015}}), 4);
    const Chessboard wide{8, 6}, square{5, 5};
    for (int i = 0; i < wide.corners(); ++i) EXPECT_EQ(turned_number(wide, i, 2), wide.corners() - 1 - i);
    EXPECT_EQ(turned_number(square, 0, 1), 4) << "the first corner of the first row goes to its end";
    for (int i = 0; i < square.corners(); ++i) EXPECT_EQ(turned_number(square, turned_number(square, i, 1), 3), i);
}

TEST(BoardTurns, AShotOfAPartKeepsItsOrder) {
    const Chessboard board{8, 6};
    const BoardShot shot{.name = "part", .corners = {{1, 1}, {2, 2}, {3, 3}}, .edge_width = 2, .square_pixels = 30, .refused = {}, .numbers = {0, 5, 46}};
    const BoardShot counted = counted_turned(shot, board, 1);
    EXPECT_EQ(counted.numbers, (std::vector<int>{1, 42, 47}));
    EXPECT_EQ(counted.corners[0].x(), 3);
    EXPECT_EQ(counted.corners[2].x(), 1);
}

TEST(BoardTurns, AreToldByThePrint) {
    Random random(67);
    const CameraModel camera = plain_camera();
    for (const Chessboard& board : {Chessboard{8, 6}, Chessboard{7, 7}}) {
        const std::vector<BoardShot> shots = seen_boards(camera, glued_board(board, random), in_a_hand, 14, 0.05, random);
        const auto right = calibrate_lens(shots, 640, 480, board);
        const auto found = calibrate_lens(counted_at_will(shots, board, random), 640, 480, board);
        ASSERT_TRUE(right && found);
        EXPECT_NEAR(found->sigma, right->sigma, 1e-3);
        for (int i = 0; i < 4; ++i) {
            EXPECT_NEAR(found->model.intrinsics()[i], right->model.intrinsics()[i], 0.02) << board.columns << " " << i;
            EXPECT_NEAR(std::sqrt(found->covariance(i, i) / right->covariance(i, i)), 1, 0.02);
        }
    }
}

TEST(BoardTurns, AnEvenPrintLeavesAllAsItIsCounted) {
    Random random(68);
    const Chessboard board{8, 6};
    const auto shots = counted_at_will(seen_boards(plain_camera(), PrintedBoard(board), standing_still, 12, 0.1, random), board, random);
    const auto lens = calibrate_lens(shots, 640, 480, board);
    ASSERT_TRUE(lens);
    for (std::size_t i = 0; i < shots.size(); ++i) EXPECT_EQ(lens->shots[i].corners, shots[i].corners);
}

TEST(BoardTurns, UpsideDownTellsTheImageCentreBetterAndTheReportSaysSo) {
    Random random(69);
    const Chessboard board{9, 6};
    std::vector<BoardShot> upright, both;
    for (const BoardShot& shot : seen_boards(plain_camera(), glued_board(board, random), in_a_hand, 80, 0.05, random)) {
        const Eigen::Vector2d along = (shot.corners[8] - shot.corners[0]).normalized();
        if (along.x() > 0.8 && upright.size() < 15) upright.push_back(shot);
        if (std::abs(along.x()) > 0.8 && both.size() < 15) both.push_back(shot);
    }
    ASSERT_EQ(upright.size(), 15U);
    const auto one_way = calibrate_lens(upright, 640, 480, board), two_ways = calibrate_lens(both, 640, 480, board);
    ASSERT_TRUE(one_way && two_ways);
    EXPECT_LT(two_ways->covariance(2, 2), 0.5 * one_way->covariance(2, 2));
    EXPECT_NE(text_of(*one_way).find("same way up"), std::string::npos);
    EXPECT_NE(html_of(*one_way, board, "").find("same way up"), std::string::npos);
    EXPECT_EQ(text_of(*two_ways).find("same way up"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
