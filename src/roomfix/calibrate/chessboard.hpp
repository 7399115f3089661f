// Chessboards in pictures: their inner corners, and whether a picture is good enough to calibrate with.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// Markers in the white squares of a ChArUco board.
struct BoardMarkers {
    std::string dictionary;  // as OpenCV names it: DICT_5X5_250, ...
    double size = 0;         // m, edge of a marker with its black border
};

/// A printed chessboard, counted by its inner corners: where four squares meet.
struct Chessboard {
    int columns = 9;
    int rows = 6;
    double square = 0.025;  // m, edge of a square
    std::optional<BoardMarkers> markers = {};

    int corners() const { return columns * rows; }
    /// Place of a corner on the board, m; corners are numbered row by row.
    Eigen::Vector2d corner(int number) const { return {square * (number % columns), square * (number / columns)}; }
};

/// Quarter turns after which a board looks as it did: 1 if it has as many columns as rows, 2 if both are odd or both even, 4 (a whole turn) for others
/// and for boards with markers.
int quarter_turns_alike(const Chessboard& board);
/// Number of the corner in whose place this one is after so many quarter turns, of which the board has a whole number of quarter_turns_alike().
int turned_number(const Chessboard& board, int number, int quarters);

/// One picture of a board.
struct BoardShot {
    std::string name;
    std::vector<Eigen::Vector2d> corners;  // px, row by row; empty: no board was found
    double edge_width = 0;                 // px over which the squares' edges rise from 10 to 90 %
    double square_pixels = 0;              // px, edge of a square in the picture, on average
    std::string refused;                   // why the picture is not used; empty: it is
    std::vector<int> numbers = {};         // of each corner on the board; empty: all of them are there

    int number(std::size_t corner) const { return numbers.empty() ? static_cast<int>(corner) : numbers[corner]; }
};

/// Looks for a board with or without markers.
BoardShot find_board(LumaView picture, const Chessboard& board, const std::string& name);
/// Looks for a board without markers, all of it; corners are refined to subpixels in a window that stays within the squares around.
BoardShot find_chessboard(LumaView picture, const Chessboard& board, const std::string& name);

/// Refuses shots without a board, blurred ones (edges wider than `sharpest` times the median, or too wide for the squares), and those
/// that show the board where a better shot does already. `diagonal`: of the picture, px.
void refuse_poor_shots(std::vector<BoardShot>& shots, const Chessboard& board, double diagonal);

/// A board of another size that a picture shows, where the one that was looked for is not there.
std::optional<Chessboard> other_board_in(LumaView picture, const Chessboard& board);

/// The board as an SVG in millimetres, with a ruler to check the printer's scale. Paper sizes are up to the printer.
std::string board_svg(const Chessboard& board);

}  // namespace roomfix
