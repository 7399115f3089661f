#include "roomfix/corner/corner_fit.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "roomfix/base/median.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {
namespace {

/// One edge in front of one camera: points on it by their distance from the corner in the normalised picture.
struct EdgeLine {
    Eigen::Vector3d corner;     // camera frame, in units of the ceiling distance
    Eigen::Vector3d direction;  // camera frame, unit
    double speed = 0;           // of the picture of the point `run` along the edge, at the corner times its depth
    double end = 1e9;           // where the picture of the edge vanishes

    EdgeLine(const Eigen::Vector3d& corner_camera, const Eigen::Vector3d& along) : corner(corner_camera), direction(along) {
        speed = (along.head<2>() - corner_camera.head<2>() * (along.z() / corner_camera.z())).norm();
        if (along.z() > 0) end = speed / along.z();
    }
    /// The point whose picture is `length` away from the corner's, on the plane at distance 1. length < end.
    Eigen::Vector3d point(double length) const { return corner + direction * (length * corner.z() / (speed - length * direction.z())); }
};

/// px of the `length` from `start` on that the picture shows, within a thirty-second of it; an edge's far end tells most of its direction.
template <class Shown>
double part_shown(const Shown& shown, double start, double length) {
    double in = 0, out = length;
    for (int i = 0; i < 5; ++i) {
        const double half = 0.5 * (in + out);
        (shown(start + half) ? in : out) = half;
    }
    return in;
}

double piece_variance(const EdgePiece& piece, const CornerFitSettings& settings) { return piece.step.variance + settings.model_sigma * settings.model_sigma; }

/// What a piece has to say; one that is off by more than `gate` standard deviations loses its say (Geman-McClure).
double piece_weight(const EdgePiece& piece, double gate, const CornerFitSettings& settings) {
    const double variance = piece_variance(piece, settings);
    const double doubt = 1 + piece.step.offset * piece.step.offset / (variance * gate * gate);
    return 1 / (variance * doubt * doubt);
}

}  // namespace

CornerFitter::CornerFitter(const CameraModel& model, const CornerFitSettings& settings) : model_(model), settings_(settings) {
    settings_.shared *= length_unit(model);
    settings_.longest *= length_unit(model);
}

void CornerFitter::look_like(const EdgeLook& look, CornerFit& fit) const {
    for (const CornerEdge edge : {x_edge, y_edge, wall_edge}) {
        const bool crease = fit.kind[edge] == EdgeKind::crease;
        fit.look[edge] = crease ? EdgeLook{settings_.crease, settings_.crease_reach, 1.5 * settings_.stretch, StepModel::crease} : look;
    }
}

void CornerFitter::read(LumaView frame, double wall_angle, int skip, CornerFit& fit) const {
    fit.pieces.clear();
    const Eigen::Matrix3d camera_from_corner = fit.view.corner_from_camera.transpose();
    const Eigen::Vector3d camera(fit.view.place.x(), fit.view.place.y(), -1);
    const Eigen::Vector3d corner = -(camera_from_corner * camera);
    if (!(corner.z() > 1e-6)) return;
    const double focal = 0.5 * (model_.fx + model_.fy);
    const auto edges = edge_directions(wall_angle);
    for (const CornerEdge edge : {x_edge, y_edge, wall_edge}) {
        const EdgeLine line(corner, camera_from_corner * edges[edge]);
        const double reach = fit.look[edge].reach * fit.look[edge].blur + 1;
        const auto shown = [&](double run) -> std::optional<Eigen::Vector2d> {
            if (!(run / focal < 0.98 * line.end)) return std::nullopt;
            const auto pixel = project(model_, line.point(run / focal));
            return pixel && model_.contains(*pixel, settings_.border) ? pixel : std::nullopt;
        };
        double start = settings_.first_gap;
        for (auto before = shown(start); before;) {
            double length = fit.look[edge].length;
            auto after = shown(start + length);
            const bool last = !after;
            if (last) {
                length = part_shown(shown, start, length);
                if (fit.look[edge].model == StepModel::coarse || length < settings_.least_part * fit.look[edge].length) break;
                after = shown(start + length);
            }
            const Eigen::Vector3d middle_camera = line.point((start + 0.5 * length) / focal);
            ProjectionJacobian jacobian;
            const auto middle = project(model_, middle_camera, &jacobian);
            if (!middle) break;
            EdgePiece piece;
            piece.edge = edge;
            piece.start = start;
            piece.length = (*after - *before).norm();
            // The lens bends the piece: the straight stretch through it stands for its mean.
            const Eigen::Vector2d bend = (2.0 / 3.0) * (*middle - 0.5 * (*before + *after));
            piece.stretch = {*before + bend, *after + bend};
            piece.middle = middle_camera;
            // The edge's point moves with the unknowns: P = R^T Exp(-r) (x - t).
            const Eigen::Vector3d arm = fit.view.corner_from_camera * middle_camera;
            const Eigen::Matrix<double, 1, 3> across = piece.stretch.normal().transpose() * jacobian;
            const Eigen::Matrix<double, 1, 3> in_corner = across * camera_from_corner;
            piece.slope.head<3>() = (in_corner * skew(arm)).transpose();
            piece.slope.tail<2>() = -in_corner.head<2>().transpose();
            piece.lift = in_corner.z();
            if (read_profile(frame, light_, piece.stretch, reach, skip, piece.profile)) judge(fit, piece);
            fit.pieces.push_back(piece);
            if (last) break;
            start += length;
            before = after;
        }
        if (fit.look[edge].model == StepModel::coarse) continue;
        leave_out_what_follows(edge, fit);
        share_contrast(edge, fit);
    }
}

/// Leaves out the pieces from where another edge begins nearly in line with this one. They are the last of the list.
void CornerFitter::leave_out_what_follows(CornerEdge edge, CornerFit& fit) const {
    std::size_t first = fit.pieces.size();
    while (first > 0 && fit.pieces[first - 1].edge == edge) --first;
    EdgeContrasts contrasts;
    for (std::size_t i = first; i < std::min(fit.pieces.size(), first + EdgeContrasts::capacity()); ++i) {
        const EdgePiece& piece = fit.pieces[i];
        contrasts.push_back({piece.step.contrast, piece.read ? 1 / (piece.step.contrast_sigma * piece.step.contrast_sigma) : 0});
    }
    const std::size_t kept = pieces_before_change(contrasts, fit.look[edge].length, settings_.change);
    if (kept < contrasts.size()) fit.pieces.resize(first + kept);
}

/// Where single pieces of an edge hardly tell that there is one, those around them together do: light and shade change along an edge, but slowly.
/// With the contrast that they share each piece's offset is known without bias, if not exactly.
void CornerFitter::share_contrast(CornerEdge edge, CornerFit& fit) const {
    constexpr std::size_t most = 128;
    FixedList<EdgePiece*, most> pieces;
    std::size_t seen = 0;
    for (EdgePiece& piece : fit.pieces) {
        if (piece.edge != edge || pieces.size() == most) continue;
        pieces.push_back(&piece);
        seen += piece.seen;
    }
    fit.shared[edge] = 2 * seen <= pieces.size();
    if (!fit.shared[edge]) return;
    struct Own {
        double contrast = 0, weight = 0;
    };
    FixedList<Own, most> own;
    for (const EdgePiece* piece : pieces) {
        const EdgeStep& step = piece->step;
        own.push_back({step.contrast, piece->read ? 1 / (step.contrast_sigma * step.contrast_sigma + settings_.least_contrast_variance) : 0});
    }
    const auto reach = static_cast<std::size_t>(std::lround(settings_.shared / fit.look[edge].length));
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        double sum = 0;
        double weights = 0;
        for (std::size_t k = i > reach ? i - reach : 0; k <= std::min(i + reach, pieces.size() - 1); ++k) {
            sum += own[k].weight * own[k].contrast;
            weights += own[k].weight;
        }
        EdgePiece& piece = *pieces[i];
        piece.seen = piece.read && std::abs(sum) > settings_.least_contrast * std::sqrt(weights);
        if (!piece.seen) continue;
        const double ratio = own[i].contrast / (sum / weights);
        piece.step.offset *= ratio;
        piece.step.variance *= ratio * ratio;
        piece.step.contrast = sum / weights;
        piece.step.contrast_sigma = 1 / std::sqrt(weights);
    }
}

/// Sums up what the pieces say, and returns the pull on the unknowns; those off by more than `gate` standard deviations lose their say.
Vector5d CornerFitter::sum_up(double gate, CornerFit& fit) const {
    Vector5d pull = Vector5d::Zero();
    double squares = 0;
    int count = 0;
    fit.information.setZero();
    for (const EdgePiece& piece : fit.pieces) {
        if (!piece.seen) continue;
        const double ratio = piece.step.offset * piece.step.offset / piece_variance(piece, settings_);
        const double weight = piece_weight(piece, gate, settings_);
        fit.information += weight * piece.slope * piece.slope.transpose();
        pull += weight * piece.step.offset * piece.slope;
        if (ratio < gate * gate) {
            squares += ratio;
            ++count;
        }
    }
    for (const CornerEdge edge : {x_edge, y_edge, wall_edge}) {
        if (fit.kind[edge] == EdgeKind::crease) leave_open_offset(edge, gate, fit, pull);
    }
    fit.counted = count;
    fit.spread = count > 5 ? squares / (count - 5) : 1;
    return pull;
}

/// All pieces of a crease may be off by the same: an unknown more, which is eliminated.
void CornerFitter::leave_open_offset(CornerEdge edge, double gate, CornerFit& fit, Vector5d& pull) const {
    Vector5d slopes = Vector5d::Zero();
    double weights = 1 / (settings_.crease_sigma * settings_.crease_sigma), offsets = 0;
    for (const EdgePiece& piece : fit.pieces) {
        if (piece.edge != edge || !piece.seen) continue;
        const double weight = piece_weight(piece, gate, settings_);
        slopes += weight * piece.slope;
        offsets += weight * piece.step.offset;
        weights += weight;
    }
    fit.information -= slopes * slopes.transpose() / weights;
    pull -= slopes * (offsets / weights);
}

/// The information factored; nothing if the pieces are not enough for all unknowns.
std::optional<Eigen::LDLT<Matrix5d>> CornerFitter::factored(const CornerFit& fit) const {
    Eigen::LDLT<Matrix5d> solver(fit.information);
    const auto pivots = solver.vectorD();
    if (fit.counted < 6 || solver.info() != Eigen::Success || !solver.isPositive() || pivots.minCoeff() <= 1e-12 * pivots.maxCoeff()) return std::nullopt;
    return solver;
}

bool CornerFitter::weigh(LumaView frame, double wall_angle, CornerFit& fit) const {
    read(frame, wall_angle, 1, fit);
    sum_up(settings_.outlier, fit);
    return factored(fit).has_value();
}

/// One step of iteratively reweighted least squares.
bool CornerFitter::step(double wall_angle, double gate, CornerFit& fit) const {
    const Vector5d pull = sum_up(gate, fit);
    const auto information = factored(fit);
    if (!information) return false;
    const Vector5d move = information->solve(pull);
    if (!move.allFinite() || move.head<3>().norm() > 0.3) return false;
    fit.view.corner_from_camera = exponential_rotation(move.head<3>()) * fit.view.corner_from_camera;
    fit.view.place += move.tail<2>();
    return is_inside(fit.view, wall_angle);
}

/// Fits the step to the piece's light and says whether it is one.
void CornerFitter::judge(const CornerFit& fit, EdgePiece& piece) const {
    const double blur = fit.look[piece.edge].blur;
    const double reach = fit.look[piece.edge].reach;
    piece.read = fit_step(piece.profile, blur, reach * blur + 1, fit.look[piece.edge].model, piece.step);
    piece.seen = piece.read && std::abs(piece.step.contrast) > settings_.least_contrast * piece.step.contrast_sigma &&
                 std::abs(piece.step.offset) < settings_.largest_offset * blur;
}

/// Judges the pieces of an edge as it is to be read now.
CornerFitter::Reading CornerFitter::reading_of(CornerEdge edge, CornerFit& fit) const {
    constexpr std::size_t most = 128;
    FixedList<double, most> noise, plainness;
    for (EdgePiece& piece : fit.pieces) {
        if (piece.edge != edge || plainness.size() == most) continue;
        judge(fit, piece);
        plainness.push_back(std::abs(piece.step.contrast) / piece.step.contrast_sigma);
        if (piece.seen) noise.push_back(piece.step.noise);
    }
    return {median(noise), median(plainness), noise.size()};
}

/// Far from everything else a wide reading tells the edge from the slopes of light beside it best; a moulding or a frame beside it allows
/// only a narrow one: it shows as noise, and hides the edge. And a faint edge needs long pieces. The pieces hold a wide reading.
void CornerFitter::choose_reach(CornerEdge edge, CornerFit& fit) const {
    EdgeLook& look = fit.look[edge];
    Reading best;
    double chosen = settings_.tight;
    for (const double reach : {settings_.tight, settings_.narrow, settings_.wide}) {
        look.reach = reach;
        look.model = reach == settings_.tight ? StepModel::plain : StepModel::full;
        const Reading now = reading_of(edge, fit);
        const bool as_good = best.seen == 0 || (now.noise < settings_.noisier * best.noise && 10 * now.seen >= 8 * best.seen);
        if (now.seen == 0 || !as_good) continue;
        best = now;
        chosen = reach;
    }
    const auto wanted = [&] { return 1.5 * settings_.stretch * std::pow(settings_.plain / std::max(best.plainness, 1e-3), 2); };
    look.reach = chosen;
    look.model = chosen == settings_.tight ? StepModel::plain : StepModel::full;
    if (wanted() > settings_.longest) {  // too faint for so many unknowns
        look.model = StepModel::sloped;
        look.reach = settings_.narrow;
    }
    best = reading_of(edge, fit);
    look.length = std::clamp(wanted(), settings_.stretch, settings_.longest);
}

void CornerFitter::update_blur(CornerFit& fit) const {
    std::array<double, 3> sigma = {1e9, 1e9, 1e9};  // px, of each edge's blur
    for (const CornerEdge edge : {x_edge, y_edge, wall_edge}) {
        if (fit.look[edge].model != StepModel::full) continue;
        double sum = 0;
        double weights = 0;
        for (const EdgePiece& piece : fit.pieces) {
            if (piece.edge != edge || !piece.seen) continue;
            const double weight = 1 / (piece.step.blur_variance + 0.01);
            sum += weight * std::clamp(piece.step.blur, settings_.least_blur, settings_.widest_blur);
            weights += weight;
        }
        if (weights <= 0) continue;
        fit.look[edge].blur = sum / weights;
        sigma[edge] = 1 / std::sqrt(weights);
    }
    // One lens drew all three: an edge that is much wider than the best known is two edges side by side (stay with the one that is
    // nearer), and one that does not tell its blur has the same.
    const auto best = static_cast<std::size_t>(std::min_element(sigma.begin(), sigma.end()) - sigma.begin());
    if (sigma[best] > 1) return;
    for (std::size_t edge = 0; edge < 3; ++edge) {
        if (fit.kind[edge] == EdgeKind::crease) continue;
        const bool merged = fit.look[edge].blur - 2 * sigma[edge] > settings_.merged * (fit.look[best].blur + 2 * sigma[best]);
        if (sigma[edge] < 1 && !merged) continue;
        fit.look[edge].blur = fit.look[best].blur;
        if (sigma[edge] > 1) continue;
        fit.look[edge].reach = settings_.tight;
        fit.look[edge].model = StepModel::plain;
    }
}

bool CornerFitter::refine(LumaView frame, double wall_angle, double capture, CornerFit& fit) const {
    const auto look = fit.look;  // which the wide steps change
    if (!approach(frame, wall_angle, capture, fit)) return false;
    if (fit.look_known) fit.look = look;
    return finish(frame, wall_angle, fit);
}

bool CornerFitter::approach(LumaView frame, double wall_angle, double capture, CornerFit& fit) const {
    // From wide and coarse to fine: a step is found within about its own blur.
    double blur = std::max(std::min(capture, settings_.widest_capture) / settings_.largest_offset, settings_.blur);
    const int rounds = capture > settings_.near ? 2 : 1;
    for (bool last = false; !last; blur *= 0.5) {
        last = blur < 1.7 || fit.look_known;
        look_like({blur, 3, 1.5 * settings_.stretch, StepModel::coarse}, fit);
        for (int i = 0; i < rounds; ++i) {
            read(frame, wall_angle, 3, fit);
            if (!step(wall_angle, 3 * settings_.outlier, fit)) return false;
        }
    }
    return true;
}

bool CornerFitter::finish(LumaView frame, double wall_angle, CornerFit& fit) const {
    if (!fit.look_known) {
        // How blurred are edges here, and how far to the side may they be read?
        look_like({settings_.blur, settings_.narrow, 1.5 * settings_.stretch, StepModel::full}, fit);
        read(frame, wall_angle, 2, fit);
        update_blur(fit);
        for (const CornerEdge edge : {x_edge, y_edge, wall_edge}) {
            if (fit.kind[edge] == EdgeKind::crease) continue;
            fit.look[edge].reach = settings_.wide;
            fit.look[edge].model = StepModel::full;
        }
        read(frame, wall_angle, 2, fit);
        for (const CornerEdge edge : {x_edge, y_edge, wall_edge}) {
            if (fit.kind[edge] != EdgeKind::crease) choose_reach(edge, fit);
        }
        update_blur(fit);
        if (!step(wall_angle, settings_.outlier, fit)) return false;
    }
    constexpr int rounds = 3;
    for (int i = fit.look_known ? 1 : 0; i < rounds; ++i) {
        read(frame, wall_angle, i < rounds - 1 ? 2 : 1, fit);
        update_blur(fit);
        if (!step(wall_angle, settings_.outlier, fit)) return false;
    }
    return true;
}

bool CornerFitter::finish_softly(LumaView frame, double wall_angle, CornerFit& fit) const {
    fit.look_known = false;
    look_like({settings_.soft_blur, settings_.tight, 1.5 * settings_.stretch, StepModel::plain}, fit);
    constexpr int rounds = 4;
    for (int i = 0; i < rounds; ++i) {
        read(frame, wall_angle, 1, fit);
        if (!step(wall_angle, settings_.outlier, fit)) return false;
    }
    return true;
}

double excess_scatter(const CornerFit& fit) {
    const double by_chance = 1 + 2 * std::sqrt(2.0 / std::max(fit.counted - 5, 1));
    return fit.spread > by_chance ? fit.spread : 1.0;
}

CornerByIntrinsics view_by_intrinsics(const CameraModel& model, const CornerFit& fit, const CornerFitSettings& settings) {
    Matrix5d information = Matrix5d::Zero();
    CornerByIntrinsics pull = CornerByIntrinsics::Zero();
    for (const CornerEdge edge : {x_edge, y_edge, wall_edge}) {
        Vector5d slopes = Vector5d::Zero();
        Eigen::Matrix<double, 1, most_intrinsics> moved = Eigen::Matrix<double, 1, most_intrinsics>::Zero();
        double weights = 1 / (settings.crease_sigma * settings.crease_sigma);
        for (const EdgePiece& piece : fit.pieces) {
            IntrinsicsJacobian by_intrinsics;
            if (piece.edge != edge || !piece.seen || !project(model, piece.middle, nullptr, &by_intrinsics)) continue;
            const double weight = piece_weight(piece, settings.outlier, settings);
            const Eigen::Matrix<double, 1, most_intrinsics> across = piece.stretch.normal().transpose() * by_intrinsics;
            information += weight * piece.slope * piece.slope.transpose();
            pull -= weight * piece.slope * across;
            slopes += weight * piece.slope;
            moved += weight * across;
            weights += weight;
        }
        if (fit.kind[edge] != EdgeKind::crease) continue;
        // The offset of the whole crease is eliminated, as in leave_open_offset().
        information -= slopes * slopes.transpose() / weights;
        pull += slopes * (moved / weights);
    }
    return information.ldlt().solve(pull);
}

std::array<EdgeSupport, 3> edge_support(const CornerFit& fit, double tolerance) {
    std::array<EdgeSupport, 3> support;
    for (const EdgePiece& piece : fit.pieces) {
        EdgeSupport& edge = support[piece.edge];
        edge.visible += piece.length;
        if (!piece.seen || std::abs(piece.step.offset) > 3 * std::sqrt(piece.step.variance) + tolerance) continue;
        edge.seen += piece.length;
        edge.first = std::min(edge.first, piece.start);
        edge.end = piece.stretch.to;
    }
    return support;
}

}  // namespace roomfix
