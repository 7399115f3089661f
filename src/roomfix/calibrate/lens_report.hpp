// A lens calibration as text for the terminal and as a page.
#pragma once

#include <string>

#include "roomfix/calibrate/lens.hpp"

namespace roomfix {

std::string text_of(const LensCalibration& lens);
/// One HTML file that needs nothing else: numbers with their standard deviations, all shots with what became of them, where in the picture
/// corners were seen, the residuals, and the error to be expected over the picture.
std::string html_of(const LensCalibration& lens, const Chessboard& board, const std::string& title);

}  // namespace roomfix
