// Calibration boards as people make and hold them, seen by simulated cameras.
#pragma once

#include <cstdint>
#include <vector>

#include "roomfix/base/random.hpp"
#include "roomfix/calibrate/printed_board.hpp"
#include "roomfix/simulate/plane_picture.hpp"

namespace roomfix {

/// A printed board, with its markers if it has some. Its first inner corner is at (0, 0).
FlatPattern pattern_of(const Chessboard& board, bool old_layout = false);

/// A board as people make them: printed unevenly (0.06 mm), stretched (0.1 %), glued onto something that is bent (0.5 mm at the ends of 20 cm) and
/// not smooth (0.04 mm).
PrintedBoard glued_board(const Chessboard& board, Random& random);

/// How a board is held, standard deviations: by how much more it is bent from shot to shot, and how far it moves while the rows of a picture are read out.
struct Hold {
    double bend = 0;             // of each number of a HeldBoard's bend: 0.001 is 0.1 mm at the ends of 20 cm
    double shift = 0, turn = 0;  // m, rad: of each number of its motion
};
constexpr Hold in_a_hand{0.001, 1e-4, 2e-4};  // as OpenCV's sample pictures show it
constexpr Hold standing_still{};

/// A board in one shot.
struct ShownBoard {
    PrintedBoard board;
    Vector6d motion = Vector6d::Zero();  // as a HeldBoard's
};
ShownBoard shown(PrintedBoard board, const Hold& hold, Random& random);

/// Where a camera sees a corner of it, px.
Eigen::Vector2d seen_corner(const CameraModel& camera, const Eigen::Isometry3d& camera_from_board, const ShownBoard& shown, int number);

/// A picture of a board as it is printed, bent and moved. `pattern`: as it should have been printed.
void photograph(PlanePictures& pictures, const FlatPattern& pattern, const ShownBoard& shown, const Eigen::Isometry3d& camera_from_board, std::uint64_t index,
                LumaImage& picture);

/// Corners of a board in front of a camera straight from geometry, with normal noise (px).
std::vector<BoardShot> seen_boards(const CameraModel& camera, const PrintedBoard& board, const Hold& hold, int count, double noise, Random& random);

}  // namespace roomfix
