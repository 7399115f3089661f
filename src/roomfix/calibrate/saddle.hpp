// Where four squares of a chessboard meet, to a hundredth of a pixel.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// Two blurred edges that cross.
struct Saddle {
    Eigen::Vector2d pixel;
    Eigen::Matrix2d covariance;  // px^2, from what the model leaves of the light
    double blur = 0;             // px, standard deviation
};

/// One of the edges as it is known before: its direction, of any length, and how a lens bends it there (1/px, to its left).
struct SaddleEdge {
    Eigen::Vector2d along;
    double bend = 0;
};

constexpr double least_saddle_radius = 2.5;  // px: less says too little

/// Fits the product of two blurred steps, under light that falls off evenly, to all pixels within `radius` px of `start`, which is within a pixel or so of the
/// truth. Bends are taken as they are. Nothing where that leads elsewhere or out of the picture. The pattern looks the same turned by half a circle, so neither
/// the camera's tone curve nor the blur's shape moves the place that is found.
std::optional<Saddle> fit_saddle(LumaView picture, const Eigen::Vector2d& start, const SaddleEdge& a, const SaddleEdge& b, double radius);

}  // namespace roomfix
