// A camera's intrinsics and lens from pictures of a chessboard, with the covariance of all of them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/calibrate/printed_board.hpp"
#include "roomfix/geometry/calibration.hpp"

namespace roomfix {

struct LensSettings {
    Distortion kind = Distortion::plumb_bob;
    int least_shots = 4;
    double worst_focal_sigma = 0.05;  // part of the focal length: less well known is not calibrated
    bool exact_board = false;         // a screen or an engraved plate that keeps still: neither its shape and print nor its motion are estimated
    double outlier = 4;               // a shot whose rms is so many times the median's is not believed
};

struct LensCalibration {
    CameraModel model;
    IntrinsicsMatrix covariance = IntrinsicsMatrix::Zero();  // in the order of IntrinsicsVector
    double rms = 0;                                          // px, per corner (both coordinates together), as OpenCV states it
    double sigma = 0;                                        // px, noise of each coordinate of a corner in most shots, estimated
    std::vector<BoardShot> shots;                            // all of them, also those refused
    std::vector<double> shot_rms;                            // px, of each shot; 0 where it was refused
    std::vector<Eigen::Isometry3d> camera_from_board;        // of each shot
    std::vector<std::vector<Eigen::Vector2d>> residuals;     // px, of each shot's corners: seen - predicted
    PrintedBoard board = PrintedBoard({});                   // as the pictures show it
    double shift = 0, turn = 0;                              // m, rad: how far it moved while a picture's rows were read out, root mean square
    bool exact_board = false;                                // it was taken as exact, and still
    double focal_sigma_by_board = 0;                         // px: part of the focal length's, since an exact board is not as exact as that
    double disagreement = 1;  // times by which the covariance is larger for it: shots contradict each other more than noise explains
    double coverage = 0;      // part of the picture (8 x 6 cells) in which corners were seen

    int used() const;
};

/// Starts from the best of many focal lengths and goes on to the least squares of our own models, with
/// the board as it was printed and all its poses estimated along, a board that looks the same when it is turned counted the way up that its print shows; the
/// covariance is that of all corners; of a board that was taken as exact, with how exact the same shots show it to be. The rational lens has a weak prior on
/// its numbers, which only their quotient fixes. Shots that contradict the others are refused, too. Errors: no board in any shot, too few good shots, shots
/// that do not fix the focal length.
Result<LensCalibration> calibrate_lens(std::vector<BoardShot> shots, int width, int height, const Chessboard& board, const LensSettings& settings = {});

/// Standard deviation (px, both coordinates together) of where a ray is imaged, once the camera's direction has been found with these
/// intrinsics: what no choice of the camera's rotation explains away. At `pixels` (2 x N).
Eigen::VectorXd predicted_error(const CameraModel& model, const IntrinsicsMatrix& covariance, const Eigen::Matrix<double, 2, Eigen::Dynamic>& pixels);

/// The covariance at another resolution of the same camera.
IntrinsicsMatrix rescaled(const IntrinsicsMatrix& covariance, const CameraModel& from, const CameraModel& to);

}  // namespace roomfix
