#include "roomfix/corner/corner_observer.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/corner/moulding.hpp"

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

}  // namespace

CornerObserver::CornerObserver(const CameraModel& model, const std::vector<double>& wall_angles, const CornerSettings& settings)
    : model_(model),
      settings_(in_pixels_of(model, settings)),
      finder_(settings.points),
      line_search_(model, settings.lines),
      search_(model, wall_angles, settings.search),
      reader_(model, settings_) {}

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
    double found = 0;
    for (const CornerHints::Expected& expected : hints.expected) {
        const double capture = 3 * expected.sigma;
        if (capture > settings_.fit.widest_capture) continue;  // it may be anywhere: look everywhere
        const auto look = [&](bool known, EdgeKind kind) {
            fit_.view = expected.view;
            return reader_.find_again(frame, expected.wall_angle, capture, kind, known, fit_);
        };
        // Edges look as in the last frame; if they do not, look afresh.
        const EdgeKind last = fit_.kind[wall_edge];
        const bool known = fit_.look_known;
        Result<double> score = known ? look(true, last) : Error{};
        for (const EdgeKind kind : {last, other_than(last)}) {
            if (!score) score = look(false, kind);
        }
        fit_.look_known = static_cast<bool>(score);
        if (!score) continue;
        // What a moulding draws changes with the place alone.
        if (!known || (fit_.view.place - beside_from_).norm() > 0.1) {
            beside_ = reader_.beside(frame, expected.wall_angle, fit_);
            beside_from_ = fit_.view.place;
        }
        add_readings(fit_, expected.wall_angle, beside_, 1, result);
        ++found;
    }
    for (CornerObservation& corner : result.corners) corner.weight /= found;
    result.predicted = !result.corners.empty();
    return result.predicted;
}

void CornerObserver::look_everywhere(LumaView frame, const CornerHints& hints, CornerResult& result) {
    finder_.find(frame, points_);
    line_search_.find(points_, finder_.reduction(), lines_);
    search_.find(lines_, hints.gravity, found_);
    const std::size_t triples = found_.candidates.size();
    const auto by_three = explain(frame, hints, result);
    if (by_three) return;
    const auto complete = [&](EdgeKind kind) {
        search_.complete(frame, reader_.light(), reader_.faint_edges(), kind, hints.gravity, found_);
        return explain(frame, hints, result);
    };
    const auto with_step = complete(EdgeKind::step);
    if (with_step) return;
    const auto with_crease = complete(EdgeKind::crease);
    if (with_crease) return;
    add_rejected({-1, -1, -1}, result);
    const Error& by_two = first_reason(with_step.error(), with_crease.error());
    result.reason = "no corner: " + reason_for_nothing(triples, first_reason(by_two, by_three.error()));
}

/// `triples`: lines of three that were tried before others were completed; `refusal`: of the likeliest explanation.
std::string CornerObserver::reason_for_nothing(std::size_t triples, const Error& refusal) const {
    if (points_.empty()) return "the picture is blank";
    if (lines_.empty()) return "there is no straight line in the picture, three that meet are needed";
    if (lines_.size() < 2) return "there is one straight line in the picture, three that meet are needed";
    if (found_.junctions.empty()) return fmt::format("none of the {} straight lines start at a common point inside the picture", lines_.size());
    if (triples == 0 && found_.candidates.empty()) {
        return "lines meet, but no three of them as two walls and a ceiling do when seen from inside the room";
    }
    return refusal.message.empty() ? "the best three lines fit none when looked at closely" : refusal.message;
}

/// Adds what a candidate explains; otherwise says why it is no corner.
Result<void> CornerObserver::try_candidate(LumaView frame, const CornerHints& hints, const CornerCandidate& candidate, bool faintly) {
    CornerExplanation explanation;
    explanation.wall_angle = candidate.wall_angle;
    explanation.lines = candidate.lines;
    CornerFit& fit = explanation.fit;
    Result<double> score = reader_.read(frame, candidate, candidate.wall_edge_kind, faintly, fit);
    // Most candidates are none: once there is an explanation, only the best of them are worth a second look.
    const bool worth_it = explanations_.empty() || candidate.score > settings_.second_look * found_.candidates[0].score;
    if (!score && worth_it && candidate.wall_edge_kind == EdgeKind::step) {
        const Error of_step = score.error();
        score = reader_.read(frame, candidate, EdgeKind::crease, faintly, fit);
        if (!score) score = first_reason(of_step, score.error());
    }
    if (!score) return score.error();
    explanation.doubt = doubt_of(fit.view, candidate.wall_angle, hints);
    if (explanation.doubt > settings_.largest_doubt) {
        return Error{"the likeliest three lines are a corner at the floor, or the camera lies on its side"};
    }
    explanation.score = *score - settings_.score_scale * explanation.doubt;
    explanations_.push_back(std::move(explanation));
    return {};
}

/// Reads the candidates' edges, fits the best of them to the end and reports what is left. If that is nothing, says why the last that was tried is no
/// corner.
Result<void> CornerObserver::explain(LumaView frame, const CornerHints& hints, CornerResult& result) {
    explanations_.clear();
    Error refusal;
    const auto take = [&](const Result<void>& outcome) {
        if (!outcome) refusal = first_reason(outcome.error(), refusal);
    };
    const std::size_t tried = std::min(found_.candidates.size(), settings_.most_tried);
    for (std::size_t i = 0; i < tried; ++i) take(try_candidate(frame, hints, found_.candidates[i], false));
    const std::size_t again = explanations_.empty() ? std::min(tried, settings_.most_refined) : 0;
    for (std::size_t i = 0; i < again; ++i) take(try_candidate(frame, hints, found_.candidates[i], true));
    take(refine_best(frame));
    if (explanations_.empty()) return refusal;
    if (!go_down(frame, explanations_[0])) return Error{"the walls' edge ends at a moulding's lower edge that makes no corner"};
    drop_upper_ones(frame);
    sort_explanations();
    if (const auto faint = explanations_[0].faint) return Error{fmt::format("the {} is too faint to be told from other lines", name_of(*faint))};
    std::erase_if(explanations_, [](const CornerExplanation& e) { return e.faint.has_value(); });
    merge_same();
    report(frame, result);
    return {};
}

void CornerObserver::sort_explanations() {
    std::stable_sort(explanations_.begin(), explanations_.end(), [](const CornerExplanation& a, const CornerExplanation& b) { return a.score > b.score; });
}

/// Fits the best few to the end; more only if none of them holds. What is far behind could not win. An error says why the last that was fitted does not hold.
Result<void> CornerObserver::refine_best(LumaView frame) {
    sort_explanations();
    merge_same();
    std::optional<double> best;  // score of those that hold
    Error refusal;
    std::vector<CornerExplanation> holding;
    for (std::size_t i = 0; i < explanations_.size(); ++i) {
        CornerExplanation& explanation = explanations_[i];
        const bool worth_it = explanation.score > settings_.worth_it * best.value_or(0) && (i < settings_.most_refined || !best);
        if (!worth_it) continue;
        const auto score = reader_.refine(frame, lines_, !best, explanation);
        if (!score) {
            refusal = first_reason(score.error(), refusal);
            continue;
        }
        explanation.score = std::max(*score - settings_.score_scale * explanation.doubt, 0.0);
        if (explanation.score > best.value_or(0)) best = explanation.score;
        holding.push_back(std::move(explanation));
    }
    explanations_ = std::move(holding);
    drop_upper_ones(frame);
    sort_explanations();
    if (refusal.message.empty()) return {};
    return refusal;
}

/// Each explanation with its weight among all.
void CornerObserver::report(LumaView frame, CornerResult& result) {
    double sum = 0;
    for (const CornerExplanation& e : explanations_) sum += std::exp((e.score - explanations_[0].score) / settings_.score_scale);
    for (const CornerExplanation& e : explanations_) {
        const double weight = std::exp((e.score - explanations_[0].score) / settings_.score_scale) / sum;
        if (weight < settings_.least_weight) break;
        add_readings(e.fit, e.wall_angle, reader_.beside(frame, e.wall_angle, e.fit), weight, result);
    }
    double kept = 0;
    for (const CornerObservation& corner : result.corners) kept += corner.weight;
    for (CornerObservation& corner : result.corners) corner.weight /= kept;
    add_rejected(explanations_[0].lines, result);
    fit_.kind = explanations_[0].fit.kind;
}

/// What was read; and where a moulding runs along the walls its other corner, too, since either may be the one that was measured.
void CornerObserver::add_readings(const CornerFit& fit, double wall_angle, const EdgesBeside& beside, double weight, CornerResult& result) const {
    CornerObservation seen = observation_of(fit, wall_angle);
    seen.weight = weight;
    seen.sighting = result.corners.empty() ? 0 : result.corners.back().sighting + 1;
    const auto moulding = moulding_beside(beside, fit.view, wall_angle);
    if (!moulding) {
        result.corners.push_back(seen);
        return;
    }
    seen.part = moulding->read;
    seen.other_rise = moulding->rise;
    seen.other_rise_sigma = moulding->rise_sigma;
    if (moulding->one_wall) {
        // The three edges need not meet in a point: taking them for a corner's turns the view by about as much as the moulding's edges are apart.
        seen.one_wall_turn = moulding->rise * moulding->rise;
    }
    CornerObservation other = other_reading(seen, *moulding);
    seen.weight *= settings_.read_is_measured;
    other.weight *= 1 - settings_.read_is_measured;
    result.corners.push_back(seen);
    result.corners.push_back(other);
}

/// The same corner from slightly different lines is one explanation: the better one, which comes first.
void CornerObserver::merge_same() {
    for (std::size_t i = 0; i < explanations_.size(); ++i) {
        const auto same = [&](const CornerExplanation& other) {
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

/// Whether `lower`'s corner lies below `upper`'s as on a moulding, and the walls' edge ends there.
bool CornerObserver::ends_at(LumaView frame, const CornerExplanation& lower, const CornerExplanation& upper) const {
    if (!moulding_between(model_, upper.fit.view, lower.fit.view, upper.wall_angle, settings_.largest_moulding)) return false;
    const double raised = lower.fit.view.place.norm() / upper.fit.view.place.norm() - 1;
    return raised > 0 && !reader_.edge_ends().continues_above(frame, lower.fit, lower.wall_angle, raised);
}

/// A moulding draws several edges on each wall. The corner is where the walls' edge ends: at the lowest of them.
void CornerObserver::drop_upper_ones(LumaView frame) {
    const auto is_upper = [&](const CornerExplanation& upper) {
        return std::any_of(explanations_.begin(), explanations_.end(), [&](const CornerExplanation& lower) {
            if (&upper == &lower || lower.score < settings_.moulding_score * upper.score) return false;
            const bool parallel = (upper.fit.view.corner_from_camera - lower.fit.view.corner_from_camera).norm() < 0.06;
            return parallel && ends_at(frame, lower, upper);
        });
    };
    std::vector<bool> drop;
    for (const CornerExplanation& e : explanations_) drop.push_back(is_upper(e));
    std::size_t i = 0;
    std::erase_if(explanations_, [&](const CornerExplanation&) { return static_cast<bool>(drop[i++]); });
}

/// The same where the lower corner was not understood by itself: it has the upper one's walls' edge. False if that edge ends at the lower corner, which
/// does not hold.
bool CornerObserver::go_down(LumaView frame, CornerExplanation& upper) {
    const bool starts_above = !upper.fit.shared[wall_edge] && edge_support(upper.fit, settings_.straightness)[wall_edge].first < settings_.fit.stretch;
    for (const CornerJunction& junction : found_.junctions) {
        CornerExplanation lower = upper;
        lower.lines = {junction.lines[0], junction.lines[1], -1};
        lower.fit.view = with_corner_raised(upper.fit.view, rise_of_corner_at(upper.fit.view, junction.point));
        const CornerView lowered = lower.fit.view;
        // What is nearer was seen when the edges were read.
        const double drop = moulding_between(model_, upper.fit.view, lowered, upper.wall_angle, settings_.largest_moulding).value_or(0);
        const auto rays = corner_rays(lowered, upper.wall_angle);
        if (drop < 3 * settings_.search_capture || !rays || !starts_edges(junction, *rays, settings_.parallel_lines)) continue;
        const auto score = reader_.read_lowered(frame, lines_, lower);
        lower.score = score ? *score - settings_.score_scale * lower.doubt : 0;
        const bool holds = lower.score > settings_.moulding_score * upper.score;
        if (holds && ends_at(frame, lower, upper)) {
            upper = std::move(lower);
            return true;
        }
        lower.fit = upper.fit;
        lower.fit.view = lowered;
        if (!holds && !starts_above && ends_at(frame, lower, upper)) return false;
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
