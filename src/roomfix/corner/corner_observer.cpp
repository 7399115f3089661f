#include "roomfix/corner/corner_observer.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

/// How unlikely a camera is that sees an edge which points down (sign 1) or up (-1), a unit vector in its frame, like this: people hold
/// cameras upright and seldom point them straight up. Half a squared number of standard deviations.
double doubt_of_hold(const Eigen::Vector3d& vertical, double sign, const CornerSettings& settings) {
    const double roll = std::atan2(std::abs(vertical.x()), sign * vertical.y());
    const double tilt = std::asin(std::min(std::abs(vertical.z()), 1.0));
    const double steep = std::max(tilt - settings.common_tilt, 0.0) / settings.tilt_sigma;
    // The closer to straight up, the less roll means.
    const double turned = roll * std::min(1.0, 2 * std::hypot(vertical.x(), vertical.y())) / settings.roll_sigma;
    return 0.5 * (turned * turned + steep * steep);
}

/// How many times more the pieces scatter than their light tells; 1 where that may be chance.
double excess_scatter(const CornerFit& fit) {
    const double by_chance = 1 + 2 * std::sqrt(2.0 / std::max(fit.counted - 5, 1));
    return fit.spread > by_chance ? fit.spread : 1.0;
}

EdgeKind other_than(EdgeKind kind) { return kind == EdgeKind::step ? EdgeKind::crease : EdgeKind::step; }

const char* const edge_names[] = {"x edge", "y edge", "walls' edge"};

}  // namespace

CornerObserver::CornerObserver(const CameraModel& model, const std::vector<double>& wall_angles, const CornerSettings& settings)
    : model_(model),
      settings_(settings),
      finder_(settings.points),
      line_search_(model, settings.lines),
      search_(model, wall_angles, settings.search),
      fitter_(model, settings.fit),
      edge_ends_(model, fitter_.light(), settings.ends),
      settler_(model, fitter_.light(), settings.faint) {
    const double unit = length_unit(model);
    for (double* length : {&settings_.long_edge, &settings_.second_edge, &settings_.short_edge, &settings_.plain_edges, &settings_.largest_gap})
        *length *= unit;
    settings_.short_edge = std::max(settings_.short_edge, settings.fit.stretch);
}

void CornerObserver::observe(LumaView frame, const CornerHints& hints, CornerResult& result) {
    result.corners.clear();
    result.rejected.clear();
    result.reason.clear();
    result.predicted = false;
    explanations_.clear();
    if (frame.width < 48 || frame.height < 48) {
        result.reason = fmt::format("a picture of {} x {} pixels is too small for a corner: 48 x 48 is the least", frame.width, frame.height);
        return;
    }
    if (look_where_expected(frame, hints, result)) return;
    look_everywhere(frame, hints, result);
}

bool CornerObserver::look_where_expected(LumaView frame, const CornerHints& hints, CornerResult& result) {
    for (const CornerHints::Expected& expected : hints.expected) {
        const double capture = 3 * expected.sigma;
        if (capture > settings_.fit.widest_capture) continue;  // it may be anywhere: look everywhere
        const auto look = [&](bool known, EdgeKind kind) {
            fit_.look_known = known;
            fit_.kind[wall_edge] = kind;
            fit_.view = expected.view;
            const bool holds = fitter_.refine(frame, expected.wall_angle, capture, fit_) && (kind == EdgeKind::step || is_deep_enough(frame, fit_));
            return holds ? score_of(fit_, true) : std::nullopt;
        };
        // Edges look as in the last frame; if they do not, look afresh.
        const EdgeKind last = fit_.kind[wall_edge];
        auto score = fit_.look_known ? look(true, last) : std::nullopt;
        for (const EdgeKind kind : {last, other_than(last)}) {
            if (!score) score = look(false, kind);
        }
        fit_.look_known = score.has_value();
        if (!score) continue;
        result.corners.push_back(observation_of(fit_, expected.wall_angle));
    }
    const double count = static_cast<double>(result.corners.size());
    for (CornerObservation& corner : result.corners) corner.weight = 1 / count;
    result.predicted = !result.corners.empty();
    return result.predicted;
}

/// Another explanation, where the first does not hold. If that holds no better, why the first does not is what people want to know.
template <class Explain>
auto CornerObserver::instead(const Explain& explain) {
    const std::string refusal = refusal_;
    auto found = explain();
    if (!found && !refusal.empty()) refusal_ = refusal;
    return found;
}

void CornerObserver::look_everywhere(LumaView frame, const CornerHints& hints, CornerResult& result) {
    finder_.find(frame, points_);
    line_search_.find(points_, finder_.reduction(), lines_);
    search_.find(lines_, hints.gravity, found_);
    refusal_.clear();
    const std::size_t triples = found_.candidates.size();
    refusal_.clear();
    if (explain(frame, hints, result)) return;
    const auto complete = [&](EdgeKind kind) {
        search_.complete(frame, fitter_.light(), settler_.edges(), kind, hints.gravity, found_);
        return explain(frame, hints, result);
    };
    if (complete(EdgeKind::step) || instead([&] { return complete(EdgeKind::crease); })) return;
    add_rejected({-1, -1, -1}, result);
    if (points_.empty()) {
        result.reason = "no corner: the picture is blank";
    } else if (lines_.size() < 2) {
        result.reason = fmt::format("no corner: {} in the picture, three that meet are needed",
                                    lines_.empty() ? "there is no straight line" : "there is one straight line");
    } else if (found_.junctions.empty()) {
        result.reason = fmt::format("no corner: none of the {} straight lines start at a common point inside the picture", lines_.size());
    } else if (triples == 0 && found_.candidates.empty()) {
        result.reason = "no corner: lines meet, but no three of them as two walls and a ceiling do when seen from inside the room";
    } else {
        result.reason = "no corner: " + (refusal_.empty() ? std::string("the best three lines fit none when looked at closely") : refusal_);
    }
}

/// Reads a candidate's edges, the walls' one as a step or as a crease. `faintly`: pieces of an edge may be too faint one by one, as long as all of them
/// together show it.
std::optional<double> CornerObserver::read_candidate(LumaView frame, const CornerCandidate& candidate, EdgeKind kind, bool faintly, CornerFit& fit) {
    fit.view = candidate.view;
    fit.kind[wall_edge] = kind;
    if (!fitter_.approach(frame, candidate.wall_angle, settings_.search_capture, fit)) return std::nullopt;
    if (const auto score = score_of(fit, false)) return score;
    if (!faintly) return std::nullopt;
    fit.view = candidate.view;
    const CornerEdge faintest = settler_.faintest(fit);
    if (settler_.settle(frame, candidate.wall_angle, faintest, fit.kind[faintest], fit.view).mean <= settings_.sure_group) return std::nullopt;
    return 0.5 * candidate.score;
}

void CornerObserver::try_candidate(LumaView frame, const CornerHints& hints, const CornerCandidate& candidate, bool faintly) {
    Explanation explanation;
    explanation.wall_angle = candidate.wall_angle;
    explanation.lines = candidate.lines;
    CornerFit& fit = explanation.fit;
    auto score = read_candidate(frame, candidate, candidate.wall_edge_kind, faintly, fit);
    // Most candidates are none: once there is an explanation, only the best of them are worth a second look.
    const bool worth_it = explanations_.empty() || candidate.score > settings_.second_look * found_.candidates[0].score;
    if (!score && worth_it && candidate.wall_edge_kind == EdgeKind::step) {
        score = instead([&] { return read_candidate(frame, candidate, EdgeKind::crease, faintly, fit); });
    }
    if (!score) return;
    explanation.doubt = doubt_of(fit.view, candidate.wall_angle, hints);
    if (explanation.doubt > settings_.largest_doubt) {
        refusal_ = "the likeliest three lines are a corner at the floor, or the camera lies on its side";
        return;
    }
    explanation.score = *score - settings_.score_scale * explanation.doubt;
    explanations_.push_back(std::move(explanation));
}

/// Reads the candidates' edges, fits the best of them to the end and reports what is left.
bool CornerObserver::explain(LumaView frame, const CornerHints& hints, CornerResult& result) {
    explanations_.clear();
    const std::size_t tried = std::min(found_.candidates.size(), settings_.most_tried);
    for (std::size_t i = 0; i < tried; ++i) try_candidate(frame, hints, found_.candidates[i], false);
    const std::size_t again = explanations_.empty() ? std::min(tried, settings_.most_refined) : 0;
    for (std::size_t i = 0; i < again; ++i) try_candidate(frame, hints, found_.candidates[i], true);
    const auto better = [](const Explanation& a, const Explanation& b) { return a.score > b.score; };
    std::stable_sort(explanations_.begin(), explanations_.end(), better);
    merge_same();
    // The best few; more only if none of them holds. What is far behind could not win.
    double best = 0;
    for (std::size_t i = 0; i < explanations_.size(); ++i) {
        Explanation& explanation = explanations_[i];
        const bool worth_it = explanation.score > settings_.worth_it * best && (i < settings_.most_refined || best == 0);
        const auto score = worth_it ? refine(frame, best == 0, explanation) : std::nullopt;
        explanation.score = score ? std::max(*score - settings_.score_scale * explanation.doubt, 0.0) : -1;
        best = std::max(best, explanation.score);
    }
    std::erase_if(explanations_, [](const Explanation& e) { return e.score < 0; });
    drop_upper_ones(frame);
    if (explanations_.empty()) return false;
    std::stable_sort(explanations_.begin(), explanations_.end(), better);
    if (!go_down(frame, explanations_[0])) {
        refusal_ = "the walls' edge ends at a moulding's lower edge that makes no corner";
        return false;
    }
    if (explanations_[0].faint) {
        refusal_ = fmt::format("the {} is too faint to be told from other lines", edge_names[*explanations_[0].faint]);
        return false;
    }
    std::erase_if(explanations_, [](const Explanation& e) { return e.faint.has_value(); });
    merge_same();

    double sum = 0;
    for (const Explanation& e : explanations_) sum += std::exp((e.score - explanations_[0].score) / settings_.score_scale);
    for (const Explanation& e : explanations_) {
        const double weight = std::exp((e.score - explanations_[0].score) / settings_.score_scale) / sum;
        if (weight < settings_.least_weight) break;
        result.corners.push_back(observation_of(e.fit, e.wall_angle));
        result.corners.back().weight = weight;
    }
    double kept = 0;
    for (const CornerObservation& corner : result.corners) kept += corner.weight;
    for (CornerObservation& corner : result.corners) corner.weight /= kept;
    add_rejected(explanations_[0].lines, result);
    fit_.kind = explanations_[0].fit.kind;
    return true;
}

/// Fits an explanation to the end. Its score; nothing if it does not hold. `second_look`: as what the walls' edge was not taken for, too.
std::optional<double> CornerObserver::refine(LumaView frame, bool second_look, Explanation& explanation) {
    const EdgeKind kind = explanation.fit.kind[wall_edge];
    const CornerView start = explanation.fit.view;
    const auto score = refine_as_is(frame, explanation);
    if (!second_look) return score;
    const auto walls_edge = [&](const CornerFit& fit) { return edge_support(fit, settings_.straightness)[wall_edge]; };
    const auto is_whole = [&](const EdgeSupport& edge) { return edge.seen > settings_.whole_edge * edge.visible; };
    const EdgeSupport own = walls_edge(explanation.fit);
    const bool is_step = kind == EdgeKind::step && explanation.seen && is_whole(own) && excess_scatter(explanation.fit) == 1;
    if (is_step || (score && kind == EdgeKind::crease) || (!score && explanation.seen)) return score;
    // Half of a crease may pass for a step.
    Explanation other;
    other.wall_angle = explanation.wall_angle;
    other.lines = explanation.lines;
    other.doubt = explanation.doubt;
    other.fit.view = start;
    other.fit.kind[wall_edge] = other_than(kind);
    if (!fitter_.approach(frame, other.wall_angle, settings_.search_capture, other.fit)) return score;
    const auto other_score = instead([&] { return refine_as_is(frame, other); });
    if (!other_score) return score;
    if (score) {
        const EdgeSupport others = walls_edge(other.fit);
        const double less_scatter = other.fit.spread / explanation.fit.spread;
        const bool better = less_scatter < settings_.clearly || (less_scatter < 1 && *other_score > *score + settings_.score_scale);
        if (!better || !is_whole(others) || others.seen < own.seen) return score;
    }
    explanation = std::move(other);
    return other_score;
}

std::optional<double> CornerObserver::refine_as_is(LumaView frame, Explanation& explanation) {
    CornerFit& fit = explanation.fit;
    settle_height(frame, explanation);
    const CornerEdge hardest = settler_.faintest(fit);
    if (fit.shared[hardest]) settler_.settle(frame, explanation.wall_angle, hardest, fit.kind[hardest], fit.view);
    const auto score = fit_to_the_end(frame, explanation.wall_angle, fit);
    if (!score || !is_seen_enough(explanation)) return std::nullopt;
    explanation.seen = true;
    const CornerEdge least = settler_.faintest(fit);
    const SettledEdge faintest = settler_.settle(frame, explanation.wall_angle, least, fit.kind[least], fit.view);
    if (faintest.moved) {
        const bool holds = fit_again(frame, explanation.wall_angle, fit) && score_of(fit, true) && is_seen_enough(explanation);
        if (!holds) return std::nullopt;
    }
    const CornerCompanions companions = companions_of(fit.view, explanation.wall_angle, lines_, model_, settings_.outside);
    if (companions.outside > companions.inside) {
        refusal_ = "the likeliest three lines are a corner that stands out into the room";
        return std::nullopt;
    }
    if (fit.kind[wall_edge] == EdgeKind::crease && !is_deep_enough(frame, fit)) {
        refusal_ = "the walls' edge is a crease too shallow to be told from the walls' grain";
        return std::nullopt;
    }
    const auto rivalled = [&] { return faintest.rival > settings_.largest_rival && !is_the_same(frame, faintest.beside, explanation); };
    if (fit.shared[faintest.edge] && (faintest.mean < settings_.least_group || rivalled())) explanation.faint = faintest.edge;
    if (!edge_ends_.end_at_corner(frame, fit, explanation.wall_angle)) {
        refusal_ = "an edge of the likeliest three lines goes on beyond where they meet";
        return std::nullopt;
    }
    return score;
}

/// Finely if the edges allow it; or softly, and finely from there. The score; nothing if that is no corner.
std::optional<double> CornerObserver::fit_to_the_end(LumaView frame, double wall_angle, CornerFit& fit) {
    const auto finely = [&] { return fitter_.finish(frame, wall_angle, fit) ? score_of(fit, true) : std::nullopt; };
    const CornerView start = fit.view;
    if (const auto score = finely()) return score;
    fit.view = start;
    if (!fitter_.finish_softly(frame, wall_angle, fit)) return std::nullopt;
    const auto soft_score = score_of(fit, true);
    if (!soft_score) return std::nullopt;
    const CornerFit soft = fit;
    if (const auto score = finely()) return score;
    fit = soft;
    return soft_score;
}

/// Where much of the three lines is missing, what is seen of them must be long; and where one of them was only completed, none may be short.
bool CornerObserver::is_seen_enough(const Explanation& explanation) {
    const auto support = edge_support(explanation.fit, settings_.straightness);
    double seen = 0;
    double visible = 0;
    double least = 1e9;
    for (const EdgeSupport& edge : support) {
        seen += edge.seen;
        visible += edge.visible;
        least = std::min(least, edge.seen);
    }
    const bool completed = explanation.lines[2] < 0;
    if (completed && least < settings_.second_edge) {
        refusal_ = fmt::format("two lines meet, but of the third only {:.0f} px are seen", least);
        return false;
    }
    if (seen < settings_.plain_part * visible && seen < settings_.plain_edges) {
        refusal_ = fmt::format("only {:.0f} % of the likeliest three lines are seen, {:.0f} px in all", 100 * seen / visible, seen);
        return false;
    }
    return true;
}

/// Walls have a grain, and are darker towards their edge: a crease is deeper than that.
bool CornerObserver::is_deep_enough(LumaView frame, const CornerFit& fit) const {
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
bool CornerObserver::is_the_same(LumaView frame, const CornerView& beside, const Explanation& explanation) const {
    CornerFit other = explanation.fit;
    other.view = beside;
    if (!fitter_.finish(frame, explanation.wall_angle, other)) return false;
    return (other.view.corner_from_camera - explanation.fit.view.corner_from_camera).norm() < settings_.settled;
}

/// Fits anew from where a faint edge was turned to. If the pieces would turn it away from there again, the light along all of it is believed.
bool CornerObserver::fit_again(LumaView frame, double wall_angle, CornerFit& fit) const {
    const CornerView turned = fit.view;
    fit.look_known = false;
    if (fitter_.finish(frame, wall_angle, fit) && (fit.view.corner_from_camera - turned.corner_from_camera).norm() < settings_.settled) return true;
    fit.view = turned;
    return fitter_.weigh(frame, wall_angle, fit);
}

/// The same corner from slightly different lines is one explanation: the better one, which comes first.
void CornerObserver::merge_same() {
    for (std::size_t i = 0; i < explanations_.size(); ++i) {
        const auto same = [&](const Explanation& other) {
            const bool turned = (other.fit.view.corner_from_camera - explanations_[i].fit.view.corner_from_camera).norm() < 0.06;
            const auto here = corner_pixel(model_, explanations_[i].fit.view, explanations_[i].wall_angle);
            const auto there = corner_pixel(model_, other.fit.view, other.wall_angle);
            return turned && here && there && (*here - *there).norm() < 3 && other.wall_angle == explanations_[i].wall_angle;
        };
        explanations_.erase(std::remove_if(explanations_.begin() + static_cast<std::ptrdiff_t>(i) + 1, explanations_.end(), same), explanations_.end());
    }
}

/// What speaks against a camera that stands like this. A corner at the floor draws the same lines: where the camera would stand upright
/// before that one, it is that one.
double CornerObserver::doubt_of(const CornerView& view, double wall_angle, const CornerHints& hints) const {
    const Eigen::Matrix3d camera_from_corner = view.corner_from_camera.transpose();
    const Eigen::Vector3d down = -camera_from_corner.col(2);
    if (hints.gravity) {
        const double off = std::acos(std::clamp(down.dot(hints.gravity->down), -1.0, 1.0)) / hints.gravity->sigma;
        return 0.5 * off * off;
    }
    const double ceiling = doubt_of_hold(down, 1, settings_);
    const auto edges = edge_directions(wall_angle);
    for (const CornerEdge edge : {x_edge, y_edge}) {
        const Eigen::Vector3d up = camera_from_corner * edges[edge];
        if (up.y() < 0 && doubt_of_hold(up, -1, settings_) + 0.5 < ceiling) return 2 * settings_.largest_doubt;
    }
    return ceiling;
}

/// Pixels of edge that the picture confirms, less what is missing; nothing if that is no corner.
std::optional<double> CornerObserver::score_of(const CornerFit& fit, bool final_fit) {
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
            refusal_ = fmt::format("the {} is not seen near the corner", edge_names[i]);
            return std::nullopt;
        }
    }
    std::sort(seen.begin(), seen.end());
    if (seen[2] < ease * settings_.long_edge || seen[1] < ease * settings_.second_edge || seen[0] < ease * settings_.short_edge) {
        refusal_ = fmt::format("of the likeliest three lines only {:.0f}, {:.0f} and {:.0f} px are seen", seen[2], seen[1], seen[0]);
        return std::nullopt;
    }
    if (counted < ease * settings_.least_seen * possible) {
        refusal_ = fmt::format("only {:.0f} % of the likeliest three lines are seen", 100 * counted / possible);
        return std::nullopt;
    }
    if (final_fit && fit.spread > settings_.largest_spread) {
        refusal_ = "the likeliest three lines are not straight enough for edges of a room";
        return std::nullopt;
    }
    return std::max(score / unit, 0.0);
}

/// A moulding draws several edges on each wall, one above the other. The corner is where the edge between the walls ends: at the lowest of
/// them.
void CornerObserver::settle_height(LumaView frame, Explanation& explanation) {
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

/// How far `lower`'s corner lies below `upper`'s along the walls' edge, px; nothing where a moulding would not put it there.
std::optional<double> CornerObserver::below(const CornerView& upper, const CornerView& lower, double wall_angle) const {
    const auto above = corner_pixel(model_, upper, wall_angle);
    const auto under = corner_pixel(model_, lower, wall_angle);
    const auto rays = corner_rays(upper, wall_angle);
    if (!above || !under || !rays) return std::nullopt;
    const Eigen::Vector2d apart = *under - *above;
    const double drop = apart.dot(rays->directions[wall_edge]);
    const bool along_wall = std::sqrt(std::max(apart.squaredNorm() - drop * drop, 0.0)) < 0.4 * drop + 1;
    if (drop < 2 || drop > settings_.largest_moulding * model_.height || !along_wall) return std::nullopt;
    return drop;
}

/// The same for explanations whose corners lie farther apart than one reading across an edge reaches.
void CornerObserver::drop_upper_ones(LumaView frame) {
    const auto is_upper = [&](const Explanation& upper) {
        return std::any_of(explanations_.begin(), explanations_.end(), [&](const Explanation& lower) {
            if (&upper == &lower || lower.score < settings_.moulding_score * upper.score) return false;
            const bool parallel = (upper.fit.view.corner_from_camera - lower.fit.view.corner_from_camera).norm() < 0.06;
            if (!parallel || !below(upper.fit.view, lower.fit.view, upper.wall_angle)) return false;
            const double raised = upper.fit.view.place.norm() > 0 ? lower.fit.view.place.norm() / upper.fit.view.place.norm() - 1 : 0;
            return raised > 0 && !edge_ends_.continues_above(frame, lower.fit, lower.wall_angle, raised);
        });
    };
    std::vector<bool> drop;
    for (const Explanation& e : explanations_) drop.push_back(is_upper(e));
    std::size_t i = 0;
    std::erase_if(explanations_, [&](const Explanation&) { return static_cast<bool>(drop[i++]); });
}

/// Whether two lines meet there as the corner's x and y edges do.
bool CornerObserver::is_parallel(const CornerJunction& junction, const CornerView& view, double wall_angle) const {
    const auto rays = corner_rays(view, wall_angle);
    if (!rays) return false;
    const auto along = [&](int line, CornerEdge edge) {
        return junction.directions[static_cast<std::size_t>(line)].dot(rays->directions[edge]) > std::cos(settings_.parallel_lines);
    };
    return (along(0, x_edge) && along(1, y_edge)) || (along(1, x_edge) && along(0, y_edge));
}

/// The same where the lower corner was not understood by itself: it has the upper one's walls' edge. False if that ends at the lower corner, but the
/// lower corner does not hold.
bool CornerObserver::go_down(LumaView frame, Explanation& upper) {
    for (const CornerJunction& junction : found_.junctions) {
        const double rise = rise_of_corner_at(upper.fit.view, junction.point);
        const CornerView lowered = with_corner_raised(upper.fit.view, rise);
        // What is nearer was seen when the edges were read.
        const bool far_enough = below(upper.fit.view, lowered, upper.wall_angle).value_or(0) > 3 * settings_.search_capture;
        if (!far_enough || !is_parallel(junction, lowered, upper.wall_angle)) continue;
        Explanation lower = upper;
        lower.lines = {junction.lines[0], junction.lines[1], -1};
        lower.fit.view = lowered;
        const auto ends_there = [&] {
            const double raised = lower.fit.view.place.norm() / upper.fit.view.place.norm() - 1;
            return raised > 0 && !edge_ends_.continues_above(frame, lower.fit, lower.wall_angle, raised);
        };
        const bool approached = fitter_.approach(frame, lower.wall_angle, settings_.search_capture, lower.fit);
        const auto score = approached ? refine_as_is(frame, lower) : std::nullopt;
        if (score && *score > settings_.moulding_score * upper.score && below(upper.fit.view, lower.fit.view, upper.wall_angle)) {
            if (!ends_there()) continue;
            lower.score = *score;
            upper = std::move(lower);
            return true;
        }
        const bool starts_above = !upper.fit.shared[wall_edge] && edge_support(upper.fit, settings_.straightness)[wall_edge].first < settings_.fit.stretch;
        lower.fit = upper.fit;
        lower.fit.view = lowered;
        if (!starts_above && ends_there()) return false;
    }
    return true;
}

CornerObservation CornerObserver::observation_of(const CornerFit& fit, double wall_angle) const {
    CornerObservation observation;
    observation.view = fit.view;
    observation.wall_angle = wall_angle;
    observation.covariance = fit.information.inverse() * excess_scatter(fit);
    if (settings_.by_intrinsics) observation.by_intrinsics = view_by_intrinsics(model_, fit, settings_.fit);
    if (const auto pixel = corner_pixel(model_, fit.view, wall_angle)) observation.pixel = pixel->cast<float>();
    const auto support = edge_support(fit, settings_.straightness);
    for (std::size_t i = 0; i < 3; ++i) {
        observation.edges[i].ends = {observation.pixel, support[i].end.cast<float>()};
        observation.edges[i].visible = static_cast<float>(support[i].visible);
        observation.edges[i].seen = static_cast<float>(support[i].seen);
    }
    return observation;
}

void CornerObserver::add_rejected(const std::array<int, 3>& used, CornerResult& result) const {
    constexpr std::size_t most = 40;
    for (std::size_t i = 0; i < lines_.size() && result.rejected.size() < most; ++i) {
        if (std::find(used.begin(), used.end(), static_cast<int>(i)) != used.end()) continue;
        const auto ends = lines_[i].ends();
        const auto from = project(model_, ends[0].homogeneous());
        const auto to = project(model_, ends[1].homogeneous());
        if (from && to) result.rejected.push_back({from->cast<float>(), to->cast<float>()});
    }
}

}  // namespace roomfix
