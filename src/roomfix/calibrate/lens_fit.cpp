#include "roomfix/calibrate/lens_fit.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/levenberg_marquardt.hpp"

namespace roomfix {
namespace {

constexpr double usual_shift = 1e-4;  // m, of a board while a picture is read out
constexpr double usual_turn = 4e-4;   // rad
constexpr double rational_sigma = 1;  // of each of k1 to k6: their quotient is known better than they are

/// Of numbers whose squares add up to this. Few numbers tell little of a spread: it is expected to be half-normal itself, some `usual`.
double likeliest_spread(double squares, double numbers, double usual) {
    constexpr double least = 1e-8;
    const double weight = 1 / (usual * usual);
    return std::max(least, std::sqrt((std::sqrt(numbers * numbers + 4 * weight * squares) - numbers) / (2 * weight)));
}

/// What is expected of a shot's own numbers, as weights over the noise's: nothing of its pose.
HeldVector held_weights(const LensSpread& spread) {
    HeldVector sigma;
    sigma << Vector6d::Zero(), Eigen::Vector3d::Constant(spread.held), Eigen::Vector3d::Constant(spread.shift), Eigen::Vector3d::Constant(spread.turn);
    HeldVector weights = HeldVector::Zero();
    weights.tail<held_numbers - bend_at>() = (spread.noise / sigma.tail<held_numbers - bend_at>().array()).square();
    return weights;
}
HeldVector held_values(const HeldBoard& held) {
    HeldVector values;
    values << Vector6d::Zero(), held.bend, held.motion;
    return values;
}

/// Adds a shot to `fit`: its own part, and what it says of all that is shared. False if a corner cannot be seen.
bool add_shot(const LensUnknowns& unknowns, const HeldBoard& held, const BoardShot& shot, const LensSpread& spread, LensFit& fit) {
    const int intrinsics = unknowns.model.intrinsics_count(), smooth = intrinsics + smooth_numbers;
    ShotFit own;
    own.mixed.setZero(held_numbers, unknowns.shared());
    const Eigen::Matrix3d turn = held.camera_from_board.linear();
    const double counts = 1 / held.noise;
    for (std::size_t i = 0; i < shot.corners.size(); ++i) {
        const int number = shot.number(i);
        const Eigen::Matrix<double, 3, smooth_numbers> by_shape = corner_by_shape(unknowns.board.nominal, number);
        const Eigen::Vector3d turned = turn * (unknowns.board.corner(number) + by_shape.leftCols<bend_numbers>() * held.bend);
        ProjectionJacobian by_point;
        IntrinsicsJacobian by_intrinsics;
        const double late = (shot.corners[i].y() + 0.5) / unknowns.model.height - 0.5;  // parts of the time from the first row to the last
        const Eigen::Vector3d moved = held.motion.head<3>() + held.motion.tail<3>().cross(turned);
        const Eigen::Vector3d in_camera = turned + held.camera_from_board.translation() + late * moved;
        const auto pixel = project(unknowns.model, in_camera, &by_point, &by_intrinsics);
        if (!pixel) return false;
        fit.farthest = std::max(fit.farthest, in_camera.hnormalized().norm());
        const Eigen::Vector2d residual = shot.corners[i] - *pixel, r = counts * residual;
        by_point *= counts;
        by_intrinsics *= counts;
        const Eigen::Matrix<double, 2, 3> by_offset = by_point * turn;
        Eigen::Matrix<double, 2, 6> by_pose;
        by_pose << by_point, -by_point * skew(turned);
        Eigen::Matrix<double, 2, held_numbers> j;
        j << by_pose, by_offset * by_shape.leftCols<bend_numbers>(), late * by_pose;
        Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, most_intrinsics + smooth_numbers> k(2, smooth);
        k << by_intrinsics.leftCols(intrinsics), by_offset * by_shape;
        const int at = smooth + 3 * number;
        // Products over the two coordinates of a pixel: written out, since the way that Eigen takes for large matrices is slow with so few rows.
        own.by_held += j.transpose().lazyProduct(j);
        own.mixed.leftCols(smooth) += j.transpose().lazyProduct(k);
        own.mixed.middleCols<3>(at) += j.transpose().lazyProduct(by_offset);
        own.held_gradient += j.transpose() * r;
        own.residuals.push_back(residual);
        own.squares += residual.squaredNorm();
        fit.squares += r.squaredNorm();
        fit.information.topLeftCorner(smooth, smooth) += k.transpose().lazyProduct(k);
        fit.information.block(at, 0, 3, smooth) += by_offset.transpose().lazyProduct(k);
        fit.information.block(0, at, smooth, 3) += k.transpose().lazyProduct(by_offset);
        fit.information.block<3, 3>(at, at) += by_offset.transpose().lazyProduct(by_offset);
        fit.gradient.head(smooth) += k.transpose().lazyProduct(r);
        fit.gradient.segment<3>(at) += by_offset.transpose().lazyProduct(r);
    }
    const HeldVector weights = held_weights(spread), values = held_values(held);
    own.by_held.diagonal() += weights;
    own.held_gradient -= weights.cwiseProduct(values);
    fit.prior_squares += weights.dot(values.cwiseAbs2());
    const Eigen::LDLT<HeldMatrix> alone(own.by_held);
    fit.information -= own.mixed.transpose() * alone.solve(own.mixed);
    fit.gradient -= own.mixed.transpose() * alone.solve(own.held_gradient);
    fit.shots.push_back(std::move(own));
    return true;
}

/// All that is expected to be zero but for its standard deviation.
void add_prior(const LensUnknowns& unknowns, const LensSpread& spread, LensFit& fit) {
    const int intrinsics = unknowns.model.intrinsics_count();
    const auto expect_zero = [&](int k, double value, double sigma) {
        const double weight = std::pow(spread.noise / sigma, 2);
        fit.prior[k] = weight;
        fit.gradient[k] -= weight * value;
        fit.prior_squares += weight * value * value;
    };
    if (unknowns.model.kind == Distortion::rational_polynomial) {
        for (const int k : {4, 5, 8, 9, 10, 11}) expect_zero(k, unknowns.model.intrinsics()[k], rational_sigma);
    }
    const PrintedBoard& board = unknowns.board;
    for (int k = 0; k < smooth_numbers; ++k) expect_zero(intrinsics + k, board.shape[k], k + 1 == smooth_numbers ? spread.stretch : spread.bend);
    for (int k = 0; k < board.offsets.size(); ++k) {
        expect_zero(intrinsics + smooth_numbers + k, board.offsets.reshaped()[k], k % 3 == 2 ? spread.relief : spread.print);
    }
    fit.information.diagonal() += fit.prior;
}

LensFit nothing_known(const LensUnknowns& unknowns) {
    const int count = unknowns.shared();
    LensFit fit;
    fit.information.setZero(count, count);
    fit.gradient.setZero(count);
    fit.prior.setZero(count);
    return fit;
}

std::optional<LensFit> linearise(const LensUnknowns& unknowns, const std::vector<const BoardShot*>& shots, const LensSpread& spread) {
    LensFit fit = nothing_known(unknowns);
    for (std::size_t i = 0; i < shots.size(); ++i) {
        if (!add_shot(unknowns, unknowns.held[i], *shots[i], spread, fit)) return std::nullopt;
    }
    add_prior(unknowns, spread, fit);
    return fit;
}

/// Of a unit diagonal: the numbers are of very different sizes.
struct Scaled {
    Eigen::VectorXd scale;
    Eigen::MatrixXd unit;

    explicit Scaled(const Eigen::MatrixXd& information)
        : scale(information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse()), unit(scale.asDiagonal() * information * scale.asDiagonal()) {}
};

Eigen::VectorXd damped_lens_step(const LensFit& at, double damping) {
    Scaled scaled(at.information);
    scaled.unit.diagonal() *= 1 + damping;
    return scaled.scale.asDiagonal() * scaled.unit.ldlt().solve(scaled.scale.asDiagonal() * at.gradient);
}

LensUnknowns moved(const LensUnknowns& from, const LensFit& at, const Eigen::VectorXd& step) {
    LensUnknowns to = from;
    const int intrinsics = from.model.intrinsics_count();
    IntrinsicsVector numbers = from.model.intrinsics();
    numbers.head(intrinsics) += step.head(intrinsics);
    to.model.set_intrinsics(numbers);
    to.board.move(step.tail(from.board.numbers()));
    for (std::size_t i = 0; i < at.shots.size(); ++i) {
        const ShotFit& shot = at.shots[i];
        const HeldVector own = shot.by_held.ldlt().solve(shot.held_gradient - shot.mixed * step);
        to.held[i].camera_from_board = perturbed(from.held[i].camera_from_board, own.head<6>());
        to.held[i].bend += own.segment<bend_numbers>(bend_at);
        to.held[i].motion += own.tail<6>();
    }
    return to;
}

/// Whether a rational lens has a pole among the corners or close behind them: where a zero hides it, the corners fit well, and nothing else does.
bool has_pole(const CameraModel& model, double farthest) {
    if (model.kind != Distortion::rational_polynomial) return false;
    constexpr double beyond = 1.1, least = 0.1;
    constexpr int steps = 50;
    const auto& k = model.distortion;
    for (int i = 1; i <= steps; ++i) {
        const double squared = std::pow(beyond * farthest * i / steps, 2);
        if (1 + squared * (k[5] + squared * (k[6] + squared * k[7])) < least) return true;
    }
    return false;
}

}  // namespace

LensSpread usual_spread(const Chessboard& board) {
    // 0.05 and 0.1 mm of a square of 25 mm; 0.2 mm and 1 mm at the ends of 20 cm; printers feed paper more or less; a hand moves by some mm in a second.
    return {.noise = usual_noise,
            .print = 0.002 * board.square,
            .relief = 0.004 * board.square,
            .held = 0.002,
            .bend = 0.01,
            .stretch = 0.002,
            .shift = usual_shift,
            .turn = usual_turn};
}

LensSpread exact_board_spread(double noise) {
    constexpr double none = 1e-9;  // m, or as a part
    return {.noise = noise, .print = none, .relief = none, .held = none, .bend = none, .stretch = none, .shift = none, .turn = none};
}

Eigen::MatrixXd LensFit::covariance(double noise) const {
    const Scaled scaled(information);
    const auto spectrum = symmetric_eigen(scaled.unit);
    const Eigen::VectorXd inverse = spectrum.eigenvalues().cwiseMax(1e-15).cwiseInverse();
    const Eigen::MatrixXd axes = noise * scaled.scale.asDiagonal() * spectrum.eigenvectors();
    return axes * inverse.asDiagonal() * axes.transpose();
}

std::optional<LensFit> fit_lens(LensUnknowns& unknowns, const std::vector<const BoardShot*>& shots, const LensSpread& spread) {
    auto at = linearise(unknowns, shots, spread);
    if (!at) return std::nullopt;
    levenberg_marquardt({.least = 1e-12, .most = 1e10, .rounds = 200}, [&](double damping) {
        LensUnknowns there = moved(unknowns, *at, damped_lens_step(*at, damping));
        auto next = linearise(there, shots, spread);
        if (!next || !(next->cost() <= at->cost()) || has_pole(there.model, next->farthest)) return StepResult::worse;
        const bool settled = at->cost() - next->cost() < 1e-12 * at->cost();
        unknowns = std::move(there);
        at = std::move(next);
        return settled ? StepResult::settled : StepResult::better;
    });
    return at;
}

std::optional<LensSpread> learned_spread(const LensUnknowns& unknowns, const LensFit& fit, const LensSpread& spread) {
    // How many numbers the pictures determine, of each kind: one less what the prior knew.
    const Eigen::MatrixXd shared = fit.covariance(1);
    const Eigen::VectorXd determined = 1 - fit.prior.array() * shared.diagonal().array();
    const auto of_corners = determined.tail(unknowns.board.offsets.size()).reshaped(3, unknowns.board.nominal.corners());
    const auto sigma = [](double squares, double numbers, double least, double most) {
        return std::clamp(std::sqrt(squares / std::max(numbers, 1e-9)), least, most);
    };
    const double square = unknowns.board.nominal.square;
    const auto& offsets = unknowns.board.offsets;
    LensSpread learned = spread;
    learned.print = sigma(offsets.topRows<2>().squaredNorm(), of_corners.topRows(2).sum(), 1e-5 * square, 0.05 * square);
    learned.relief = sigma(offsets.row(2).squaredNorm(), of_corners.row(2).sum(), 1e-5 * square, 0.05 * square);
    double freedom = -determined.sum();
    const HeldVector weights = held_weights(spread);
    HeldVector squares = HeldVector::Zero(), numbers = HeldVector::Zero();
    for (std::size_t i = 0; i < fit.shots.size(); ++i) {
        const ShotFit& shot = fit.shots[i];
        const HeldMatrix alone = shot.by_held.inverse();
        const HeldMatrix all = alone + alone * shot.mixed * shared * shot.mixed.transpose() * alone;
        const HeldVector of_shot = 1 - weights.array() * all.diagonal().array();
        freedom += 2 * static_cast<double>(shot.residuals.size()) - of_shot.sum();
        squares += held_values(unknowns.held[i]).cwiseAbs2();
        numbers += of_shot;
    }
    if (freedom < 1) return std::nullopt;
    learned.held = sigma(squares.segment<bend_numbers>(bend_at).sum(), numbers.segment<bend_numbers>(bend_at).sum(), 1e-6, spread.bend);
    learned.shift = likeliest_spread(squares.segment<3>(motion_at).sum(), numbers.segment<3>(motion_at).sum(), usual_shift);
    learned.turn = likeliest_spread(squares.tail<3>().sum(), numbers.tail<3>().sum(), usual_turn);
    learned.noise = std::max(std::sqrt(fit.squares / freedom), 1e-6);
    return learned;
}

void learn_shot_noise(LensUnknowns& unknowns, const LensFit& fit, const LensSpread& spread) {
    constexpr double usual = 20;  // coordinates, of the usual noise, that count beside a shot's own
    double all = 0, own_squares = 0;
    for (std::size_t i = 0; i < fit.shots.size(); ++i) {
        all += 2 * static_cast<double>(fit.shots[i].residuals.size());
        own_squares += fit.shots[i].squares / std::pow(unknowns.held[i].noise, 2);
    }
    const double variance = spread.noise * spread.noise, free = own_squares / variance / all;  // part of a coordinate that no unknown has taken up
    for (std::size_t i = 0; i < fit.shots.size(); ++i) {
        const double count = free * 2 * static_cast<double>(fit.shots[i].residuals.size());
        unknowns.held[i].noise = std::sqrt((usual + fit.shots[i].squares / variance) / (usual + count));
    }
}

double disagreement(const LensUnknowns& unknowns, const std::vector<const BoardShot*>& shots, const LensSpread& spread, const LensFit& fit) {
    const int intrinsics = unknowns.model.intrinsics_count();
    const Scaled all(fit.information);
    const Eigen::MatrixXd columns = Eigen::MatrixXd::Identity(all.unit.rows(), intrinsics);
    // Over the noise's variance.
    const Eigen::MatrixXd covariance = all.unit.ldlt().solve(columns).topRows(intrinsics), weight = covariance.inverse();
    double moved = 0, expected = 0;
    for (std::size_t i = 0; i < shots.size(); ++i) {
        LensFit own = nothing_known(unknowns);
        add_shot(unknowns, unknowns.held[i], *shots[i], spread, own);
        const Eigen::MatrixXd others = all.unit - all.scale.asDiagonal() * own.information * all.scale.asDiagonal();
        const Eigen::MatrixXd by_gradient = others.ldlt().solve(columns);
        const Eigen::VectorXd step = by_gradient.transpose() * (all.scale.asDiagonal() * own.gradient);
        moved += step.dot(weight * step);
        expected += (weight * (by_gradient.topRows(intrinsics) - covariance)).trace();
    }
    return std::max(1.0, moved / (expected * spread.noise * spread.noise));
}

}  // namespace roomfix
