// Z. Chou, W.-H. Tsai 1986, section 4: a camera calibrated by a grid before it. As published.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/calibrate/chessboard.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/geometry/lens_grid.hpp"

namespace roomfix {

/// Section 4.1: where a lens without distortion would show the grid. `seen`: px, row by row, of a grid on a plane parallel to the picture.
/// The lens is good in its middle: a similarity that fits the points nearest to `centre` (px) is carried on to all others.
struct IdealGrid {
    std::vector<Eigen::Vector2d> points;  // px
    double spacing = 0;                   // w, px between neighbouring points
};
Result<IdealGrid> ideal_grid(const std::vector<Eigen::Vector2d>& seen, const Chessboard& grid, const Eigen::Vector2d& centre);

/// Section 4.2: f = k d / w, px: points of the grid are `spacing_px` apart in the picture and `square` apart in truth, `distance` away
/// (m). Nothing if one of them is not positive.
std::optional<double> focal_length(double spacing_px, double distance, double square);

/// Section 4.3: the image centre is where lines parallel to the optical axis meet: two sides of a rectangle on a wall along the view, each
/// given by two pixels. Nothing if they are parallel in the picture.
std::optional<Eigen::Vector2d> image_centre(const Eigen::Vector2d& a0, const Eigen::Vector2d& a1, const Eigen::Vector2d& b0, const Eigen::Vector2d& b1);

/// What the paper does not state: how well fx, fy (one number), cx and cy are then known. `distance_sigma`: of `distance`, m; `centre_sigma`: px.
IntrinsicsMatrix published_covariance(double focal, double distance, double distance_sigma, double centre_sigma);

/// The whole picture as a lens without distortion would show it: bilinear resampling, section 4.1. Black where the grid says nothing.
void correct_picture(LumaView seen, const LensGrid& grid, LumaImage& corrected);

}  // namespace roomfix
