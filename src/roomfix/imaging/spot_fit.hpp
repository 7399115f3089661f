// The centre of a small bright spot to hundredths of a pixel, also where its middle is saturated.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct SpotFitSettings {
    int radius = 5;            // px: half the window's edge, at most 7
    double read_noise = 1.5;   // grey levels; only its ratio to the shot noise matters, the covariance takes the noise from the fit
    double shot_noise = 0.12;  // grey levels^2 per grey level
    double gamma = 2.2;        // of the camera: grey = 255 light^(1 / gamma). A wrong one widens the covariance and moves nothing
    int saturated = 250;       // grey levels: such a pixel says only "at least as bright"
    int rounds = 6;
    double reach = 3.6;  // widths of the spot: pixels farther from its middle do not count
};

struct SpotFit {
    Eigen::Vector2d centre;      // px
    Eigen::Matrix2d covariance;  // px^2, for the noise of the settings: multiply by the mean `noise` of the frame's spots
    double amplitude = 0;        // light above the ground, also where it is cut off by saturation; 1 = grey level 255
    double width = 0;            // px, standard deviation
    double ground = 0;           // grey level around the spot
    double peak = 0;             // grey level of its middle, at most 255
    double noise = 1;            // variance of the residuals about what the settings say, where the centre is decided
};

/// What is known of a spot beforehand, from its fellows: the lens blurs all of them alike.
struct SpotPrior {
    double width = 0.8;             // px
    double width_sigma = 0.05;      // relative
    double amplitude = 2;           // light
    double amplitude_sigma = 0.35;  // relative
};

/// Intensity-weighted centroid of a window around `near` (px): where fits start. Nothing too close to the border or without contrast.
std::optional<Eigen::Vector2d> spot_centroid(LumaView frame, const Eigen::Vector2d& near, int radius);

/// Weighted least squares of a Gaussian of light on a sloping ground, through the camera's response (centre, amplitude, width, ground and its slope); saturated
/// pixels count only where the model stays below them, outliers (another lamp's edge) less. Nothing if it does not converge to a spot in the window. With a
/// prior a spot can be fitted that a lamp's glare nearly hides.
std::optional<SpotFit> fit_spot(LumaView frame, const Eigen::Vector2d& start, const SpotFitSettings& settings = {}, const SpotPrior* prior = nullptr);

}  // namespace roomfix
