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

/// How differently from shot to shot a board is bent that somebody holds: 0.1 mm at the ends of 20 cm.
constexpr double usual_held_bend = 0.001;
/// The board as it is bent in one shot.
PrintedBoard held_board(PrintedBoard board, double held_bend, Random& random);

/// A picture of a board as it is printed and bent. `pattern`: as it should have been printed.
void photograph(PlanePictures& pictures, const FlatPattern& pattern, const PrintedBoard& board, const Eigen::Isometry3d& camera_from_board, std::uint64_t index,
                LumaImage& picture);

/// Corners of a board in front of a camera straight from geometry, with normal noise (px). `held_bend`: how differently the board is bent
/// in each shot (see HeldBoard), standard deviation.
std::vector<BoardShot> seen_boards(const CameraModel& camera, const PrintedBoard& board, double held_bend, int count, double noise, Random& random);

}  // namespace roomfix
