// Least squares over all that pictures of a board depend on: the lens, the board as it was printed, and where it was held.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "roomfix/calibrate/printed_board.hpp"
#include "roomfix/geometry/calibration.hpp"

namespace roomfix {

constexpr int bend_numbers = 3;  // the first of a SmoothShape

/// How the board was held in a shot.
struct HeldBoard {
    Eigen::Isometry3d camera_from_board = Eigen::Isometry3d::Identity();  // when the middle row was exposed
    Eigen::Vector3d bend = Eigen::Vector3d::Zero();                       // how much more it was bent than on average
    Vector6d motion = Vector6d::Zero();  // from the first row to the last: shift, m, and turn, rad, in the frame of the camera (a rolling shutter)
    double noise = 1;                    // of its corners over the usual one
};

/// All that is estimated.
struct LensUnknowns {
    CameraModel model;
    PrintedBoard board;
    std::vector<HeldBoard> held;  // in each shot

    /// Those that all shots share: the intrinsics, then the board's numbers.
    int shared() const { return model.intrinsics_count() + board.numbers(); }
};

/// Standard deviations: of corners in the picture, and of how a board is off before anything is seen.
struct LensSpread {
    double noise;    // px, of each coordinate
    double print;    // m, of each corner in the plane of the board
    double relief;   // m, of each corner's height
    double held;     // of each number of a HeldBoard's bend
    double bend;     // of a SmoothShape: of its first three numbers,
    double stretch;  // and of the last
    double shift;    // m, of each number of a HeldBoard's motion:
    double turn;     // rad
};

constexpr double usual_noise = 0.1;                // px
LensSpread usual_spread(const Chessboard& board);  // before a board has been looked at: printed on paper, glued onto cardboard
LensSpread exact_board_spread(double noise);       // a screen, or an engraved plate

/// A shot's own numbers: those of its pose, its bend, its motion.
constexpr int bend_at = 6, motion_at = bend_at + bend_numbers, held_numbers = motion_at + 6;
using HeldVector = Eigen::Matrix<double, held_numbers, 1>;
using HeldMatrix = Eigen::Matrix<double, held_numbers, held_numbers>;

/// One shot linearised; its own numbers can be eliminated.
struct ShotFit {
    HeldMatrix by_held = HeldMatrix::Zero();                    // J^T J, with what is expected of bends
    Eigen::Matrix<double, held_numbers, Eigen::Dynamic> mixed;  // J^T K, K by what is shared
    HeldVector held_gradient = HeldVector::Zero();              // J^T r
    std::vector<Eigen::Vector2d> residuals;                     // px, seen - predicted
    double squares = 0;                                         // px^2
};

/// What is known of all that is shared once all that shots have of their own is eliminated; in units of the corners' noise.
struct LensFit {
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
    Eigen::VectorXd prior;  // its part of the information's diagonal
    double squares = 0;     // px^2, each shot's over its HeldBoard's noise
    double prior_squares = 0;
    double farthest = 0;  // of all corners from the optical axis: tangent of the angle
    std::vector<ShotFit> shots;

    double cost() const { return squares + prior_squares; }
    Eigen::MatrixXd covariance(double noise) const;
};

/// Levenberg-Marquardt from where `unknowns` are, which become the best. Nothing if a corner cannot be seen from there.
std::optional<LensFit> fit_lens(LensUnknowns& unknowns, const std::vector<const BoardShot*>& shots, const LensSpread& spread);

/// The spread that makes what was found likeliest (MacKay 1992, one step of its fixed point); bend and stretch of the SmoothShape stay. Nothing where no more
/// is measured than is unknown.
std::optional<LensSpread> learned_spread(const LensUnknowns& unknowns, const LensFit& fit, const LensSpread& spread);

/// How still each board was held, by its residuals: shots of boards that move, or bend in ways of their own, count less. `spread`: as learned from this fit.
void learn_shot_noise(LensUnknowns& unknowns, const LensFit& fit, const LensSpread& spread);

/// How much more the intrinsics move when single shots are left out than the noise of their corners explains, as a factor of the covariance, 1 or more: a board
/// that moves, or bends in ways of its own, shifts many corners of a shot together. (A jackknife, in one step: Quenouille 1956.)
double disagreement(const LensUnknowns& unknowns, const std::vector<const BoardShot*>& shots, const LensSpread& spread, const LensFit& fit);

}  // namespace roomfix
