// ChArUco boards: a chessboard with numbered markers in its white squares, so that a part of it is enough.
#pragma once

#include "roomfix/calibrate/chessboard.hpp"

namespace roomfix {

/// Was the program built with OpenCV's aruco module?
bool can_read_charuco();

/// Names of the dictionaries that markers may be of, as in OpenCV: DICT_4X4_50, ...
std::vector<std::string> marker_dictionaries();

/// An error where the board's markers are of no known dictionary, do not fit into its squares, or are too many.
Result<void> check_charuco(const Chessboard& board);

/// Looks for the board's markers and for the corners between them, those that are in sight. Both layouts of boards with an even number of
/// rows of squares are known: OpenCV's since 4.6.0 and the one before.
BoardShot find_charuco(LumaView picture, const Chessboard& board, const std::string& name);

/// A marker of the board and its square, in squares from the board's upper left one.
struct BoardMarker {
    int number = 0;
    int column = 0, row = 0;
};
std::vector<BoardMarker> markers_of(const Chessboard& board, bool old_layout = false);
/// The marker's bits with its black border, row by row; 1 is white.
std::vector<std::vector<bool>> marker_bits(const Chessboard& board, int number);

}  // namespace roomfix
