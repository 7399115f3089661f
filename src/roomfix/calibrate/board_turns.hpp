// Which way round a board was held, where its pattern does not show it.
#pragma once

#include <vector>

#include "roomfix/calibrate/lens_fit.hpp"

namespace roomfix {

/// The same corners, counted as if the board had been held turned by so many times quarter_turns_alike().
BoardShot counted_turned(const BoardShot& shot, const Chessboard& board, int times);

/// By how many times each shot is to be counted turned for all of them to show the same print: its errors are what tells its ways up apart. `fit`: of all
/// shots, counted as they are.
std::vector<int> turns_by_print(const LensUnknowns& unknowns, const LensFit& fit, const std::vector<const BoardShot*>& shots);

}  // namespace roomfix
