#include "roomfix/calibrate/lens.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>

#include "roomfix/calibrate/lens_start.hpp"

namespace roomfix {
namespace {

/// One shot linearised: the poses are eliminated shot by shot.
struct ShotFit {
    Matrix6d by_pose = Matrix6d::Zero();                        // J^T J
    IntrinsicsMatrix by_intrinsics = IntrinsicsMatrix::Zero();  // K^T K
    PoseByIntrinsics mixed = PoseByIntrinsics::Zero();          // J^T K
    Vector6d pose_gradient = Vector6d::Zero();                  // J^T r
    IntrinsicsVector gradient = IntrinsicsVector::Zero();       // K^T r
    std::vector<Eigen::Vector2d> residuals;
    double squares = 0;
};

std::optional<ShotFit> linearise(const CameraModel& model, const Eigen::Isometry3d& camera_from_board, const BoardShot& shot, const Chessboard& board) {
    ShotFit fit;
    for (std::size_t i = 0; i < shot.corners.size(); ++i) {
        const Eigen::Vector2d on_board = board.corner(shot.number(i));
        const Eigen::Vector3d turned = camera_from_board.linear() * Eigen::Vector3d(on_board.x(), on_board.y(), 0);
        ProjectionJacobian by_point;
        IntrinsicsJacobian k;
        const auto pixel = project(model, turned + camera_from_board.translation(), &by_point, &k);
        if (!pixel) return std::nullopt;
        Eigen::Matrix<double, 2, 6> j;
        j << by_point, -by_point * skew(turned);
        const Eigen::Vector2d r = shot.corners[i] - *pixel;
        fit.by_pose += j.transpose() * j;
        fit.by_intrinsics += k.transpose() * k;
        fit.mixed += j.transpose() * k;
        fit.pose_gradient += j.transpose() * r;
        fit.gradient += k.transpose() * r;
        fit.residuals.push_back(r);
        fit.squares += r.squaredNorm();
    }
    return fit;
}

/// The intrinsics' information once all poses are eliminated, and its gradient.
struct Reduced {
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
    double squares = 0;
    double prior_squares = 0;
    std::vector<ShotFit> shots;

    double cost() const { return squares + prior_squares; }
};

constexpr double rational_sigma = 1;  // of each of k1 to k6 before anything is seen: their quotient is known better than they are
constexpr double about_noise = 0.1;   // px, of corners: how much the prior weighs beside them

std::optional<Reduced> reduce(const LensSolution& solution, const std::vector<const BoardShot*>& used, const Chessboard& board) {
    const int count = solution.model.intrinsics_count();
    Reduced reduced{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count), 0, 0, {}};
    if (solution.model.kind == Distortion::rational_polynomial) {
        const double weight = std::pow(about_noise / rational_sigma, 2);
        for (const int k : {4, 5, 8, 9, 10, 11}) {
            const double value = solution.model.intrinsics()[k];
            reduced.information(k, k) += weight;
            reduced.gradient[k] -= weight * value;
            reduced.prior_squares += weight * value * value;
        }
    }
    for (std::size_t i = 0; i < used.size(); ++i) {
        auto fit = linearise(solution.model, solution.camera_from_board[i], *used[i], board);
        if (!fit) return std::nullopt;
        const Eigen::LDLT<Matrix6d> pose(fit->by_pose);
        const Eigen::MatrixXd mixed = fit->mixed.leftCols(count);
        reduced.information += fit->by_intrinsics.topLeftCorner(count, count) - mixed.transpose() * pose.solve(mixed);
        reduced.gradient += fit->gradient.head(count) - mixed.transpose() * pose.solve(fit->pose_gradient);
        reduced.squares += fit->squares;
        reduced.shots.push_back(std::move(*fit));
    }
    return reduced;
}

/// Scaled to a unit diagonal: the numbers are of very different sizes.
Eigen::MatrixXd scaled_inverse(const Eigen::MatrixXd& information) {
    const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd unit = scale.asDiagonal() * information * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(unit);
    const Eigen::VectorXd inverse = spectrum.eigenvalues().cwiseMax(1e-15).cwiseInverse();
    return scale.asDiagonal() * (spectrum.eigenvectors() * inverse.asDiagonal() * spectrum.eigenvectors().transpose()) * scale.asDiagonal();
}

/// How much more the shots contradict each other than the noise of their corners explains, as a factor of the covariance, 1 or more: a board
/// that is not flat moves all corners of a shot together. `variance`: of a corner's coordinate, px^2.
double disagreement(const Reduced& fit, double variance, int count) {
    constexpr double least = 1e-9;  // of the largest eigenvalue: less is no information
    double squares = 0, numbers = 0;
    const Eigen::VectorXd scale = fit.information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    for (const ShotFit& shot : fit.shots) {
        const Eigen::LDLT<Matrix6d> pose(shot.by_pose);
        const Eigen::MatrixXd mixed = shot.mixed.leftCols(count);
        const Eigen::MatrixXd information = shot.by_intrinsics.topLeftCorner(count, count) - mixed.transpose() * pose.solve(mixed);
        const Eigen::VectorXd gradient = shot.gradient.head(count) - mixed.transpose() * pose.solve(shot.pose_gradient);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(scale.asDiagonal() * information * scale.asDiagonal());
        const Eigen::VectorXd along = spectrum.eigenvectors().transpose() * (scale.asDiagonal() * gradient);
        for (Eigen::Index i = 0; i < along.size(); ++i) {
            if (spectrum.eigenvalues()[i] < least * spectrum.eigenvalues().maxCoeff()) continue;
            squares += along[i] * along[i] / (spectrum.eigenvalues()[i] * variance);
            ++numbers;
        }
    }
    return numbers > count ? std::max(1.0, squares / (numbers - count)) : 1;
}

/// Levenberg-Marquardt on all numbers of our own models.
Reduced polish(LensSolution& solution, const std::vector<const BoardShot*>& used, const Chessboard& board, Reduced at) {
    const int count = solution.model.intrinsics_count();
    double damping = 1e-3;
    for (int round = 0; round < 200 && damping < 1e10; ++round) {
        Eigen::MatrixXd damped = at.information;
        damped.diagonal() *= 1 + damping;
        const Eigen::VectorXd step = scaled_inverse(damped) * at.gradient;
        LensSolution moved = solution;
        IntrinsicsVector numbers = moved.model.intrinsics();
        numbers.head(count) += step;
        moved.model.set_intrinsics(numbers);
        for (std::size_t i = 0; i < used.size(); ++i) {
            const ShotFit& fit = at.shots[i];
            const Vector6d d = fit.by_pose.ldlt().solve(fit.pose_gradient - fit.mixed.leftCols(count) * step);
            moved.camera_from_board[i] = perturbed(solution.camera_from_board[i], d);
        }
        auto next = reduce(moved, used, board);
        if (!next || !(next->cost() <= at.cost())) {
            damping *= 10;
            continue;
        }
        const bool settled = at.cost() - next->cost() < 1e-12 * at.cost();
        solution = std::move(moved);
        at = std::move(*next);
        damping = std::max(damping * 0.1, 1e-12);
        if (settled) break;
    }
    return at;
}

double covered(const std::vector<const BoardShot*>& used, int width, int height) {
    std::set<std::pair<int, int>> cells;
    for (const BoardShot* shot : used) {
        for (const Eigen::Vector2d& c : shot->corners)
            cells.insert({static_cast<int>(8 * (c.x() + 0.5) / width), static_cast<int>(6 * (c.y() + 0.5) / height)});
    }
    return static_cast<double>(cells.size()) / 48;
}

std::string refusals(const std::vector<BoardShot>& shots) {
    std::string text;
    for (const BoardShot& s : shots) {
        if (!s.refused.empty()) text += fmt::format("\n  {}: {}", s.name, s.refused);
    }
    return text;
}

/// A shot that fits far worse than the others, if there is one.
BoardShot* outlier_among(std::vector<BoardShot*>& used, const Reduced& fit, double times) {
    std::vector<double> rms;
    for (const ShotFit& s : fit.shots) rms.push_back(std::sqrt(s.squares / static_cast<double>(s.residuals.size())));
    std::vector<double> sorted = rms;
    std::sort(sorted.begin(), sorted.end());
    const double usual = sorted[sorted.size() / 2];
    const auto worst = std::max_element(rms.begin(), rms.end());
    if (*worst < times * usual) return nullptr;
    BoardShot* shot = used[static_cast<std::size_t>(worst - rms.begin())];
    shot->refused =
        fmt::format("its corners are off by {:.2f} px rms, those of the others by {:.2f} px: was the board bent, moving, or partly hidden?", *worst, usual);
    return shot;
}

}  // namespace

int LensCalibration::used() const {
    return static_cast<int>(std::count_if(shots.begin(), shots.end(), [](const BoardShot& s) { return s.refused.empty(); }));
}

Result<LensCalibration> calibrate_lens(std::vector<BoardShot> shots, int width, int height, const Chessboard& board, const LensSettings& settings) {
    refuse_poor_shots(shots, board, std::hypot(width, height));
    const bool none = std::none_of(shots.begin(), shots.end(), [](const BoardShot& s) { return !s.corners.empty(); });
    if (none && board.markers) return Error{"no picture shows the board:" + refusals(shots)};
    if (none) return Error{fmt::format("no picture shows a board with {} x {} inner corners: count where four squares meet", board.columns, board.rows)};
    LensCalibration result;
    LensSolution solution;
    std::optional<Reduced> fit;
    std::vector<BoardShot*> used;
    for (;;) {
        used.clear();
        for (BoardShot& s : shots) {
            if (s.refused.empty()) used.push_back(&s);
        }
        if (static_cast<int>(used.size()) < settings.least_shots) {
            return Error{fmt::format("{} good shots, {} or more are needed: show the board near, far, in the corners and tilted{}", used.size(),
                                     settings.least_shots, refusals(shots))};
        }
        const std::vector<const BoardShot*> all(used.begin(), used.end());
        const auto start = start_of_lens(all, width, height, board, settings.kind);
        if (start) solution = *start;
        fit = start ? reduce(solution, all, board) : std::nullopt;
        if (!fit) {
            return Error{fmt::format("no lens of the kind {} explains these shots: show the board tilted in several directions, or try another --model",
                                     name_of(settings.kind))};
        }
        fit = polish(solution, all, board, std::move(*fit));
        if (outlier_among(used, *fit, settings.outlier) == nullptr) break;
    }
    const std::vector<const BoardShot*> all(used.begin(), used.end());
    const int count = solution.model.intrinsics_count();
    double measured = 0;
    for (const BoardShot* shot : all) measured += 2 * static_cast<double>(shot->corners.size());
    const double freedom = measured - 6.0 * static_cast<double>(all.size()) - count;
    if (freedom < 1) return Error{"too few corners for so many unknowns: take more shots, or a board with more squares"};
    result.model = solution.model;
    result.rms = std::sqrt(fit->squares / (measured / 2));
    result.sigma = std::sqrt(fit->squares / freedom);
    const double variance = result.sigma * result.sigma;
    result.disagreement = disagreement(*fit, variance, count);
    result.covariance.topLeftCorner(count, count) = variance * result.disagreement * scaled_inverse(fit->information);
    result.coverage = covered(all, width, height);
    const double focal_sigma = std::max(std::sqrt(result.covariance(0, 0)) / result.model.fx, std::sqrt(result.covariance(1, 1)) / result.model.fy);
    if (!(focal_sigma < settings.worst_focal_sigma)) {
        return Error{
            fmt::format("these shots do not tell the focal length (known to {:.0f} %): show the board tilted by 30 to 45 degrees, in several directions{}",
                        100 * focal_sigma, refusals(shots))};
    }
    std::size_t next = 0;
    for (const BoardShot& s : shots) {
        const bool good = s.refused.empty();
        const ShotFit* own = good ? &fit->shots[next] : nullptr;
        result.shot_rms.push_back(good ? std::sqrt(own->squares / static_cast<double>(own->residuals.size())) : 0);
        result.residuals.push_back(good ? own->residuals : std::vector<Eigen::Vector2d>{});
        result.camera_from_board.push_back(good ? solution.camera_from_board[next] : Eigen::Isometry3d::Identity());
        next += good;
    }
    result.shots = std::move(shots);
    return result;
}

Eigen::VectorXd predicted_error(const CameraModel& model, const IntrinsicsMatrix& covariance, const Eigen::Matrix<double, 2, Eigen::Dynamic>& pixels) {
    const auto over = spread_pixels(model);
    // Rays whose turn is fitted are spread over the picture; those asked for follow.
    const Eigen::Index fitted = over.cols(), all = fitted + pixels.cols();
    Eigen::Matrix<double, Eigen::Dynamic, most_intrinsics> by_intrinsics = Eigen::MatrixXd::Zero(2 * all, most_intrinsics);
    Eigen::Matrix<double, Eigen::Dynamic, 3> by_turn = Eigen::MatrixXd::Zero(2 * all, 3);
    for (Eigen::Index i = 0; i < all; ++i) {
        const auto ray = unproject(model, i < fitted ? over.col(i) : pixels.col(i - fitted));
        ProjectionJacobian by_point;
        IntrinsicsJacobian k;
        if (!ray || !project(model, ray->homogeneous(), &by_point, &k)) continue;
        by_intrinsics.middleRows<2>(2 * i) = k;
        by_turn.middleRows<2>(2 * i) = -by_point * skew(ray->homogeneous());
    }
    const auto turns = by_turn.topRows(2 * fitted);
    const Eigen::Matrix3d normal = turns.transpose() * turns;
    const Eigen::Matrix<double, 3, most_intrinsics> turn = normal.ldlt().solve(turns.transpose() * by_intrinsics.topRows(2 * fitted));
    Eigen::VectorXd errors(pixels.cols());
    for (Eigen::Index i = 0; i < pixels.cols(); ++i) {
        const Eigen::Matrix<double, 2, most_intrinsics> left = by_intrinsics.middleRows<2>(2 * (fitted + i)) - by_turn.middleRows<2>(2 * (fitted + i)) * turn;
        errors[i] = std::sqrt(std::max((left * covariance * left.transpose()).trace(), 0.0));
    }
    return errors;
}

IntrinsicsMatrix rescaled(const IntrinsicsMatrix& covariance, const CameraModel& from, const CameraModel& to) {
    IntrinsicsVector scale = IntrinsicsVector::Ones();
    scale[0] = scale[2] = static_cast<double>(to.width) / from.width;
    scale[1] = scale[3] = static_cast<double>(to.height) / from.height;
    return scale.asDiagonal() * covariance * scale.asDiagonal();
}

}  // namespace roomfix
