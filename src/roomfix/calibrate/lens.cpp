#include "roomfix/calibrate/lens.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/calibrate/board_turns.hpp"
#include "roomfix/calibrate/lens_fit.hpp"
#include "roomfix/calibrate/lens_start.hpp"

namespace roomfix {
namespace {

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

/// Fits, and once more if boards turn out to lie otherwise before the lens that was found: before a lens that is not known a board that is seen
/// small, and its mirror image in depth, look alike.
std::optional<LensFit> fit_with_boards_turned(LensUnknowns& unknowns, const std::vector<const BoardShot*>& shots, const LensSpread& spread) {
    constexpr double clearly = 0.5;  // times
    auto fit = fit_lens(unknowns, shots, spread);
    if (!fit) return fit;
    bool turned = false;
    for (std::size_t i = 0; i < shots.size(); ++i) {
        const auto other = pose_of_board(unknowns.model, *shots[i], unknowns.board.nominal);
        if (!other || other->squares > clearly * fit->shots[i].squares) continue;
        unknowns.held[i] = {other->camera_from_board};
        turned = true;
    }
    return turned ? fit_lens(unknowns, shots, spread) : fit;
}

/// Fits a lens of some kind, and a board, to these shots, all of which have a pose in `start`. Nothing where no such lens explains them.
std::optional<LensFit> first_fit(LensUnknowns& unknowns, const LensStart& start, const std::vector<const BoardShot*>& shots, Distortion kind,
                                 const LensSpread& spread) {
    unknowns = {start.model, PrintedBoard(unknowns.board.nominal), {}};
    for (const auto& pose : start.camera_from_board) unknowns.held.push_back({*pose});
    auto fit = fit_with_boards_turned(unknowns, shots, spread);
    if (!fit || start.model.kind == kind) return fit;
    unknowns.model.kind = kind;
    unknowns.model.prepare();
    return fit_lens(unknowns, shots, spread);
}

/// From a board that is stiff at first, or soft at once, whichever explains more: one that may bend explains many a wrong lens, and one that may not none at
/// all where it is bent.
std::optional<LensFit> best_first_fit(LensUnknowns& unknowns, const LensStart& start, const std::vector<const BoardShot*>& shots, Distortion kind,
                                      const LensSpread& spread) {
    LensUnknowns stiff = unknowns;
    auto from_stiff = first_fit(stiff, start, shots, kind, exact_board_spread(usual_noise));
    if (from_stiff) from_stiff = fit_lens(stiff, shots, spread);
    auto fit = first_fit(unknowns, start, shots, kind, spread);
    if (!from_stiff || (fit && fit->cost() < from_stiff->cost())) return fit;
    unknowns = std::move(stiff);
    return from_stiff;
}

/// Those whose corners no lens sees so. True if there are any.
bool refuse_unexplained(const std::vector<BoardShot*>& used, const LensStart& start) {
    bool any = false;
    for (std::size_t i = 0; i < used.size(); ++i) {
        if (start.camera_from_board[i]) continue;
        used[i]->refused = "its corners are not those of a flat board seen from the front: is the picture mirrored, or the board of another size?";
        any = true;
    }
    return any;
}

/// A shot that fits far worse than the others, if there is one.
BoardShot* outlier_among(std::vector<BoardShot*>& used, const LensFit& fit, double times) {
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

/// What was found, and how well.
struct Estimate {
    LensUnknowns unknowns;
    LensSpread spread;
    LensFit fit;
};

/// Learns how well the board is made and how still it was held, and fits again, until both agree. False where no more is measured than is unknown.
bool settle(Estimate& found, const std::vector<const BoardShot*>& shots, bool exact_board) {
    constexpr int most_rounds = 12;
    constexpr double settled = 1e-3;  // of the noise
    for (int round = 0; round < most_rounds; ++round) {
        const auto learned = learned_spread(found.unknowns, found.fit, found.spread);
        if (!learned) return false;
        const double before = found.spread.noise;
        found.spread = exact_board ? exact_board_spread(learned->noise) : *learned;
        if (!exact_board) learn_shot_noise(found.unknowns, found.fit, found.spread);
        auto again = fit_lens(found.unknowns, shots, found.spread);
        if (!again) return false;
        found.fit = std::move(*again);
        if (round > 0 && std::abs(found.spread.noise - before) < settled * before) break;
    }
    return true;
}

/// Begins with a board of which nothing is known yet. Nothing where no more is measured than is unknown.
std::optional<Estimate> measured_anew(const LensUnknowns& start, const std::vector<const BoardShot*>& shots) {
    Estimate found{start, usual_spread(start.board.nominal), {}};
    auto fit = fit_lens(found.unknowns, shots, found.spread);
    if (!fit) return std::nullopt;
    found.fit = std::move(*fit);
    if (!settle(found, shots, false)) return std::nullopt;
    return found;
}

/// Where a board looks the same when it is turned, shots are counted so that its print agrees, if that leaves clearly less unexplained.
void settle_turns(Estimate& found, const std::vector<BoardShot*>& used) {
    constexpr double clearly = 0.9;  // of the noise; turned at will, shots of noise alone lose 3 % of it
    const Chessboard& board = found.unknowns.board.nominal;
    const std::vector<int> turns = turns_by_print(found.unknowns, found.fit, {used.begin(), used.end()});
    LensUnknowns start = found.unknowns;
    std::vector<BoardShot> counted;
    for (std::size_t i = 0; i < used.size(); ++i) {
        counted.push_back(counted_turned(*used[i], board, turns[i]));
        if (turns[i] == 0) continue;
        const auto pose = pose_of_board(start.model, counted[i], board);
        if (!pose) return;
        start.held[i].camera_from_board = pose->camera_from_board;
    }
    std::vector<const BoardShot*> shots;
    for (const BoardShot& shot : counted) shots.push_back(&shot);
    auto turned = measured_anew(start, shots);
    if (!turned || turned->spread.noise > clearly * found.spread.noise) return;
    for (std::size_t i = 0; i < used.size(); ++i) *used[i] = std::move(counted[i]);
    found = std::move(*turned);
}

/// How far the intrinsics may be off because the board is not as exact as it was taken for: the same shots measure it, too.
Eigen::MatrixXd errors_by_board(const Estimate& exact, const std::vector<const BoardShot*>& shots) {
    const int count = exact.unknowns.model.intrinsics_count(), numbers = exact.unknowns.board.numbers();
    const auto measured = measured_anew(exact.unknowns, shots);
    if (!measured) return Eigen::MatrixXd::Zero(count, count);
    const LensSpread& spread = measured->spread;
    const PrintedBoard& board = measured->unknowns.board;
    Eigen::VectorXd variance(numbers);
    // What is seen of a shape is partly chance.
    const SmoothShape chance = measured->fit.covariance(spread.noise).diagonal().segment<smooth_numbers>(count);
    const SmoothShape beyond = board.shape.cwiseAbs2() - chance;
    variance.head<bend_numbers>().setConstant(std::max(beyond.head<bend_numbers>().mean(), 0.0));
    variance[bend_numbers] = std::max(beyond[bend_numbers], 0.0);
    variance.tail(numbers - smooth_numbers) = Eigen::Vector3d(spread.print, spread.print, spread.relief).cwiseAbs2().replicate(board.offsets.cols(), 1);
    const Eigen::MatrixXd& information = exact.fit.information;
    const Eigen::MatrixXd by_board = information.topLeftCorner(count, count).ldlt().solve(information.block(0, count, count, numbers));
    return by_board * variance.asDiagonal() * by_board.transpose();
}

std::vector<BoardShot*> not_refused(std::vector<BoardShot>& shots) {
    std::vector<BoardShot*> used;
    for (BoardShot& s : shots) {
        if (s.refused.empty()) used.push_back(&s);
    }
    return used;
}

/// Before anything is known of the noise. Refuses shots until the others agree.
Result<Estimate> first_estimate(std::vector<BoardShot>& shots, int width, int height, const Chessboard& board, const LensSettings& settings) {
    Estimate found{{{}, PrintedBoard(board), {}}, settings.exact_board ? exact_board_spread(usual_noise) : usual_spread(board), {}};
    // The rational lens goes astray from far away: it starts from the plumb_bob one, which is itself without its lower half.
    const Distortion first = settings.kind == Distortion::rational_polynomial ? Distortion::plumb_bob : settings.kind;
    for (;;) {
        std::vector<BoardShot*> used = not_refused(shots);
        if (static_cast<int>(used.size()) < settings.least_shots) {
            return Error{fmt::format("{} good shots, {} or more are needed: show the board near, far, in the corners and tilted{}", used.size(),
                                     settings.least_shots, refusals(shots))};
        }
        const std::vector<const BoardShot*> all(used.begin(), used.end());
        const LensStart start = start_of_lens(all, width, height, board, first);
        if (refuse_unexplained(used, start)) continue;
        auto fit = settings.exact_board ? first_fit(found.unknowns, start, all, settings.kind, found.spread)
                                        : best_first_fit(found.unknowns, start, all, settings.kind, found.spread);
        if (!fit) {
            return Error{fmt::format("no lens of the kind {} explains these shots: show the board tilted in several directions, or try another --model",
                                     name_of(settings.kind))};
        }
        if (outlier_among(used, *fit, settings.outlier) != nullptr) continue;
        found.fit = std::move(*fit);
        return found;
    }
}

/// All but what is known of the single shots.
LensCalibration described(const Estimate& found, const std::vector<const BoardShot*>& shots, bool exact_board) {
    LensCalibration result;
    result.model = found.unknowns.model;
    result.board = found.unknowns.board;
    result.exact_board = exact_board;
    double corners = 0, squares = 0;
    for (const ShotFit& shot : found.fit.shots) {
        corners += static_cast<double>(shot.residuals.size());
        squares += shot.squares;
    }
    // What is seen of a motion is less than all of it: its spread tells how large it is.
    if (!exact_board) {
        result.shift = std::sqrt(3) * found.spread.shift;
        result.turn = std::sqrt(3) * found.spread.turn;
    }
    result.rms = std::sqrt(squares / corners);
    result.sigma = found.spread.noise;
    result.coverage = covered(shots, result.model.width, result.model.height);
    result.disagreement = disagreement(found.unknowns, shots, found.spread, found.fit);
    const int numbers = result.model.intrinsics_count();
    auto covariance = result.covariance.topLeftCorner(numbers, numbers);
    covariance = result.disagreement * found.fit.covariance(found.spread.noise).topLeftCorner(numbers, numbers);
    if (exact_board) {
        const Eigen::MatrixXd by_board = errors_by_board(found, shots);
        covariance += by_board;
        result.focal_sigma_by_board = std::sqrt(std::max(by_board(0, 0), by_board(1, 1)));
    }
    return result;
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
    auto found = first_estimate(shots, width, height, board, settings);
    if (!found) return found.error();
    const std::vector<BoardShot*> used = not_refused(shots);
    const std::vector<const BoardShot*> all(used.begin(), used.end());
    if (!settle(*found, all, settings.exact_board)) {
        return Error{"too few corners for so many unknowns: take more shots, or a board with more squares"};
    }
    if (!settings.exact_board && quarter_turns_alike(board) < 4) settle_turns(*found, used);
    LensCalibration result = described(*found, all, settings.exact_board);
    const double focal_sigma = std::max(std::sqrt(result.covariance(0, 0)) / result.model.fx, std::sqrt(result.covariance(1, 1)) / result.model.fy);
    if (!(focal_sigma < settings.worst_focal_sigma)) {
        return Error{
            fmt::format("these shots do not tell the focal length (known to {:.0f} %): show the board tilted by 30 to 45 degrees, in several directions{}",
                        100 * focal_sigma, refusals(shots))};
    }
    std::size_t next = 0;
    for (const BoardShot& s : shots) {
        const bool good = s.refused.empty();
        const ShotFit* own = good ? &found->fit.shots[next] : nullptr;
        result.shot_rms.push_back(good ? std::sqrt(own->squares / static_cast<double>(own->residuals.size())) : 0);
        result.residuals.push_back(good ? own->residuals : std::vector<Eigen::Vector2d>{});
        result.camera_from_board.push_back(good ? found->unknowns.held[next].camera_from_board : Eigen::Isometry3d::Identity());
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
