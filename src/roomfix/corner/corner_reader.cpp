#include "roomfix/corner/corner_reader.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

const Error no_reason;  // of a fit that came to nothing: there is nothing to say about it

}  // namespace

EdgeKind other_than(EdgeKind kind) { return kind == EdgeKind::step ? EdgeKind::crease : EdgeKind::step; }

const char* name_of(CornerEdge edge) {
    constexpr std::array<const char*, 3> names = {"x edge", "y edge", "walls' edge"};
    return names[edge];
}

CornerReader::CornerReader(const CameraModel& model, const CornerSettings& settings)
    : model_(model),
      settings_(settings),
      fitter_(model, settings.fit),
      edge_ends_(model, fitter_.light(), settings.ends),
      settler_(model, fitter_.light(), settings.faint) {}

Result<double> CornerReader::find_again(LumaView frame, double wall_angle, double capture, EdgeKind kind, bool look_known, CornerFit& fit) {
    fit.look_known = look_known;
    fit.kind[wall_edge] = kind;
    const bool holds = fitter_.refine(frame, wall_angle, capture, fit) && (kind == EdgeKind::step || is_deep_enough(frame, fit));
    return holds ? score_of(fit, true) : no_reason;
}

Result<double> CornerReader::read_lowered(LumaView frame, const std::vector<SceneLine>& lines, CornerExplanation& lower) {
    lower.faint.reset();
    const bool holds = fitter_.approach(frame, lower.wall_angle, settings_.search_capture, lower.fit);
    return holds ? refine_as_is(frame, lines, lower) : no_reason;
}

Result<double> CornerReader::read(LumaView frame, const CornerCandidate& candidate, EdgeKind kind, bool faintly, CornerFit& fit) {
    fit.view = candidate.view;
    fit.kind[wall_edge] = kind;
    if (!fitter_.approach(frame, candidate.wall_angle, settings_.search_capture, fit)) return no_reason;
    const auto score = score_of(fit, false);
    if (score || !faintly) return score;
    fit.view = candidate.view;
    const CornerEdge faintest = settler_.faintest(fit);
    if (settler_.settle(frame, candidate.wall_angle, faintest, fit.kind[faintest], fit.view).mean <= settings_.sure_group) return score;
    return 0.5 * candidate.score;
}

Result<double> CornerReader::refine(LumaView frame, const std::vector<SceneLine>& lines, bool second_look, CornerExplanation& explanation) {
    const EdgeKind kind = explanation.fit.kind[wall_edge];
    const CornerView start = explanation.fit.view;
    const auto score = refine_as_is(frame, lines, explanation);
    if (!second_look) return score;
    const auto walls_edge = [&](const CornerFit& fit) { return edge_support(fit, settings_.straightness)[wall_edge]; };
    const auto is_whole = [&](const EdgeSupport& edge) { return edge.seen > settings_.whole_edge * edge.visible; };
    const EdgeSupport own = walls_edge(explanation.fit);
    const bool is_step = kind == EdgeKind::step && explanation.seen && is_whole(own) && excess_scatter(explanation.fit) == 1;
    if (is_step || (score && kind == EdgeKind::crease) || (!score && explanation.seen)) return score;
    // Half of a crease may pass for a step.
    CornerExplanation other;
    other.wall_angle = explanation.wall_angle;
    other.lines = explanation.lines;
    other.doubt = explanation.doubt;
    other.fit.view = start;
    other.fit.kind[wall_edge] = other_than(kind);
    if (!fitter_.approach(frame, other.wall_angle, settings_.search_capture, other.fit)) return score;
    const auto other_score = refine_as_is(frame, lines, other);
    if (!other_score) return score ? score : Result<double>(first_reason(score.error(), other_score.error()));
    if (score) {
        const EdgeSupport others = walls_edge(other.fit);
        const double less_scatter = other.fit.spread / explanation.fit.spread;
        const bool better = less_scatter < settings_.clearly || (less_scatter < 1 && *other_score > *score + settings_.score_scale);
        if (!better || !is_whole(others) || others.seen < own.seen) return score;
    }
    explanation = std::move(other);
    return other_score;
}

Result<double> CornerReader::refine_as_is(LumaView frame, const std::vector<SceneLine>& lines, CornerExplanation& explanation) {
    CornerFit& fit = explanation.fit;
    settle_height(frame, explanation);
    const CornerEdge hardest = settler_.faintest(fit);
    if (fit.shared[hardest]) settler_.settle(frame, explanation.wall_angle, hardest, fit.kind[hardest], fit.view);
    const auto score = fit_to_the_end(frame, explanation.wall_angle, fit);
    if (!score) return score;
    if (const auto enough = is_seen_enough(explanation); !enough) return enough.error();
    explanation.seen = true;
    const CornerEdge least = settler_.faintest(fit);
    const SettledEdge faintest = settler_.settle(frame, explanation.wall_angle, least, fit.kind[least], fit.view);
    if (faintest.moved) {
        if (!fit_again(frame, explanation.wall_angle, fit)) return no_reason;
        if (const auto again = score_of(fit, true); !again) return again;
        if (const auto enough = is_seen_enough(explanation); !enough) return enough.error();
    }
    const CornerCompanions companions = companions_of(fit.view, explanation.wall_angle, lines, model_, settings_.outside);
    if (companions.outside > companions.inside) return Error{"the likeliest three lines are a corner that stands out into the room"};
    if (fit.kind[wall_edge] == EdgeKind::crease && !is_deep_enough(frame, fit)) {
        return Error{"the walls' edge is a crease too shallow to be told from the walls' grain"};
    }
    const auto rivalled = [&] { return faintest.rival > settings_.largest_rival && !is_the_same(frame, faintest.beside, explanation); };
    if (fit.shared[faintest.edge] && (faintest.mean < settings_.least_group || rivalled())) explanation.faint = faintest.edge;
    if (!edge_ends_.end_at_corner(frame, fit, explanation.wall_angle)) return Error{"an edge of the likeliest three lines goes on beyond where they meet"};
    return score;
}

/// Finely if the edges allow it; or softly, and finely from there. The score; nothing if that is no corner.
Result<double> CornerReader::fit_to_the_end(LumaView frame, double wall_angle, CornerFit& fit) {
    const auto finely = [&]() -> Result<double> { return fitter_.finish(frame, wall_angle, fit) ? score_of(fit, true) : no_reason; };
    const CornerView start = fit.view;
    const auto fine_score = finely();
    if (fine_score) return fine_score;
    fit.view = start;
    if (!fitter_.finish_softly(frame, wall_angle, fit)) return fine_score;
    const auto soft_score = score_of(fit, true);
    if (!soft_score) return soft_score;
    const CornerFit soft = fit;
    if (const auto score = finely()) return score;
    fit = soft;
    return soft_score;
}

/// Where much of the three lines is missing, what is seen of them must be long; and where one of them was only completed, none may be short.
Result<void> CornerReader::is_seen_enough(const CornerExplanation& explanation) const {
    const auto support = edge_support(explanation.fit, settings_.straightness);
    double seen = 0;
    double visible = 0;
    double least = 1e9;
    for (const EdgeSupport& edge : support) {
        seen += edge.seen;
        visible += edge.visible;
        least = std::min(least, edge.seen);
    }
    if (explanation.completed() && least < settings_.second_edge) {
        return Error{fmt::format("two lines meet, but of the third only {:.0f} px are seen", least)};
    }
    if (seen < settings_.plain_part * visible && seen < settings_.plain_edges) {
        return Error{fmt::format("only {:.0f} % of the likeliest three lines are seen, {:.0f} px in all", 100 * seen / visible, seen)};
    }
    return {};
}

/// Walls have a grain, and are darker towards their edge: a crease is deeper than that.
bool CornerReader::is_deep_enough(LumaView frame, const CornerFit& fit) const {
    double depth = 0, light = 0;
    for (const EdgePiece& piece : fit.pieces) {
        if (piece.edge != wall_edge || !piece.seen) continue;
        const Eigen::Vector2d middle = 0.5 * (piece.stretch.from + piece.stretch.to);
        depth += piece.length * piece.step.contrast;
        const std::uint8_t grey = frame.row(static_cast<int>(middle.y()))[static_cast<int>(middle.x())];
        light += piece.length * static_cast<double>(fitter_.light()[grey]);
    }
    return depth < -settings_.least_depth * light;
}

/// Whether a fit from a line beside the edge comes back to the edge: then they are one, wide and uneven.
bool CornerReader::is_the_same(LumaView frame, const CornerView& beside, const CornerExplanation& explanation) const {
    CornerFit other = explanation.fit;
    other.view = beside;
    if (!fitter_.finish(frame, explanation.wall_angle, other)) return false;
    return (other.view.corner_from_camera - explanation.fit.view.corner_from_camera).norm() < settings_.settled;
}

/// Fits anew from where a faint edge was turned to. If the pieces would turn it away from there again, the light along all of it is believed.
bool CornerReader::fit_again(LumaView frame, double wall_angle, CornerFit& fit) const {
    const CornerView turned = fit.view;
    fit.look_known = false;
    if (fitter_.finish(frame, wall_angle, fit) && (fit.view.corner_from_camera - turned.corner_from_camera).norm() < settings_.settled) return true;
    fit.view = turned;
    return fitter_.weigh(frame, wall_angle, fit);
}

/// Pixels of edge that the picture confirms, less what is missing.
Result<double> CornerReader::score_of(const CornerFit& fit, bool final_fit) const {
    const auto support = edge_support(fit, final_fit ? settings_.straightness : 10);
    const double unit = length_unit(model_);
    std::array<double, 3> seen{};
    double counted = 0;
    double possible = 0;
    double score = 0;
    const double ease = final_fit ? 1.0 : 0.7;
    for (std::size_t i = 0; i < 3; ++i) {
        seen[i] = support[i].seen;
        counted += std::min(support[i].seen, 200 * unit);
        possible += std::min(support[i].visible, 200 * unit);
        score += support[i].seen - 0.5 * std::min(support[i].visible - support[i].seen, 100 * unit) - std::min(support[i].first, 60 * unit);
        if (support[i].first > settings_.largest_gap / ease) {
            return Error{fmt::format("the {} is not seen near the corner", name_of(static_cast<CornerEdge>(i)))};
        }
    }
    std::sort(seen.begin(), seen.end());
    if (seen[2] < ease * settings_.long_edge || seen[1] < ease * settings_.second_edge || seen[0] < ease * settings_.short_edge) {
        return Error{fmt::format("of the likeliest three lines only {:.0f}, {:.0f} and {:.0f} px are seen", seen[2], seen[1], seen[0])};
    }
    if (counted < ease * settings_.least_seen * possible) {
        return Error{fmt::format("only {:.0f} % of the likeliest three lines are seen", 100 * counted / possible)};
    }
    if (final_fit && fit.spread > settings_.largest_spread) return Error{"the likeliest three lines are not straight enough for edges of a room"};
    return std::max(score / unit, 0.0);
}

/// A moulding draws several edges on each wall, one above the other. The corner is where the edge between the walls ends: at the lowest of
/// them.
void CornerReader::settle_height(LumaView frame, CornerExplanation& explanation) {
    CornerFit& fit = explanation.fit;
    fitter_.look_like({1, LightProfile::widest, 1.5 * settings_.fit.stretch, StepModel::coarse}, fit);
    fitter_.read(frame, explanation.wall_angle, 1, fit);
    find_parallel_corners(fit, model_.height, settings_.parallel, parallels_);
    // From the fit's own corner downwards: each lower one, unless the walls' edge goes on above it.
    const CornerView before = fit.view;
    const double own = 2.0 / model_.height;
    for (const ParallelCorner& lower : parallels_) {
        if (lower.rise > -own) break;
        fit.view = with_corner_raised(before, lower.rise);
        if (!edge_ends_.continues_above(frame, fit, explanation.wall_angle, -lower.rise)) return;
    }
    fit.view = before;
}

EdgesBeside CornerReader::beside(LumaView frame, double wall_angle, const CornerFit& fit) {
    around_.kind = fit.kind;
    fitter_.look_like({1, LightProfile::widest, 1.5 * settings_.fit.stretch, StepModel::coarse}, around_);
    const auto read = [&](double rise) {
        around_.view = with_corner_raised(fit.view, rise);
        fitter_.read(frame, wall_angle, 1, around_);
    };
    read(0);
    std::array<double, 2> lift = {0, 0};
    for (const EdgePiece& piece : around_.pieces) {
        if (piece.edge != wall_edge && lift[piece.edge] == 0) lift[piece.edge] = std::abs(piece.lift);
    }
    if (lift[0] < 1 || lift[1] < 1) return {};
    BesideVotes votes(lift, length_unit(model_), settings_.parallel);
    for (int k = -BesideVotes::most; k <= BesideVotes::most; ++k) {
        read(votes.rise(k));
        votes.add(around_, k);
    }
    return votes.found();
}

}  // namespace roomfix
