#include "roomfix/corner/faint_edge.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "roomfix/geometry/pose.hpp"

namespace roomfix {
namespace {

constexpr double coarse_turn = 0.6;  // deg
constexpr double fine_turn = 0.15;   // deg
constexpr double coarse_soft = 2.5;
constexpr int coarse_skip = 3;
constexpr int fine_skip = 1;
constexpr std::size_t most_peaks = 3;
constexpr double worth_a_look = 0.4;     // part of the best coarse evidence
constexpr double least_variance = 0.02;  // of a piece's contrast, squared levels of light

}  // namespace

double saturated(double squared, const FaintEdgeSettings& settings) { return settings.saturation * std::log1p(squared / settings.saturation); }

FaintEdges::FaintEdges(const CameraModel& model, const FaintEdgeSettings& settings) : model_(model), settings_(settings), focal_(0.5 * (model.fx + model.fy)) {}

EdgeEvidence FaintEdges::along(LumaView frame, const LightTable& light, const Eigen::Vector2d& corner, const Eigen::Vector2d& direction, EdgeKind kind,
                               int skip, double softer) const {
    EdgeEvidence evidence;
    const bool crease = kind == EdgeKind::crease;
    const double blur = softer * (crease ? settings_.crease : settings_.blur);
    const StepModel model = crease ? StepModel::crease : StepModel::plain;
    const double reach = std::min(5 * blur + 0.5, LightProfile::widest);
    EdgeContrasts pieces;
    const auto pixel_at = [&](double run) { return project(model_, (corner + direction * (run / focal_)).eval().homogeneous()); };
    auto before = pixel_at(settings_.first_gap);
    LightProfile profile;
    EdgeStep step;
    while (pieces.size() < EdgeContrasts::capacity()) {
        const auto after = pixel_at(settings_.first_gap + settings_.piece * static_cast<double>(pieces.size() + 1));
        if (!before || !after || !model_.contains(*before, settings_.border) || !model_.contains(*after, settings_.border)) break;
        const bool read = read_profile(frame, light, {*before, *after}, reach, skip, profile) && fit_step(profile, blur, reach, model, step);
        pieces.push_back(read ? PieceContrast{step.contrast, 1 / std::max(step.contrast_sigma * step.contrast_sigma, least_variance)} : PieceContrast{});
        before = after;
    }
    const std::size_t count = pieces_before_change(pieces, settings_.piece, settings_.change);
    evidence.visible = settings_.piece * static_cast<double>(count);
    const auto together = static_cast<std::size_t>(settings_.together);
    for (std::size_t first = 0; first < count; first += together) {
        const std::size_t last = std::min(first + together, count);
        if (2 * (last - first) < together && first > 0) break;
        const PieceContrast group = mean_of(pieces, first, last);
        const double squared = group.weight * group.contrast * group.contrast;
        evidence.plain += saturated(squared, settings_);
        if (squared < settings_.plain_group) continue;
        evidence.seen += settings_.piece * static_cast<double>(last - first);
        evidence.first = std::min(evidence.first, settings_.first_gap + settings_.piece * static_cast<double>(first));
    }
    return evidence;
}

void FaintEdges::peaks(LumaView frame, const LightTable& light, const Eigen::Vector2d& corner, const Eigen::Vector2d& direction, EdgeKind kind, double span,
                       std::vector<Peak>& found) const {
    const auto look = [&](double turn, int skip, double softer) {
        return Peak{turn, along(frame, light, corner, Eigen::Rotation2Dd(turn) * direction, kind, skip, softer)};
    };
    // Coarsely everywhere, then finely where it looked best.
    const double step = radians(coarse_turn);
    const int steps = static_cast<int>(std::ceil(span / step));
    std::vector<Peak> coarse;
    for (int i = -steps; i <= steps; ++i) coarse.push_back(look(i * step, coarse_skip, coarse_soft));
    const auto plainer = [](const Peak& a, const Peak& b) { return a.evidence.plain > b.evidence.plain; };
    std::vector<Peak> tops;
    for (std::size_t i = 0; i < coarse.size(); ++i) {
        const bool above_left = i == 0 || coarse[i].evidence.plain >= coarse[i - 1].evidence.plain;
        const bool above_right = i + 1 == coarse.size() || coarse[i].evidence.plain > coarse[i + 1].evidence.plain;
        if (above_left && above_right) tops.push_back(coarse[i]);
    }
    std::stable_sort(tops.begin(), tops.end(), plainer);
    while (tops.size() > most_peaks || (tops.size() > 1 && tops.back().evidence.plain < worth_a_look * tops.front().evidence.plain)) tops.pop_back();
    found.clear();
    for (const Peak& top : tops) {
        Peak best;
        for (double turn = -step; turn <= step; turn += radians(fine_turn)) {
            const Peak fine = look(top.turn + turn, fine_skip, 1);
            if (best.evidence.plain < fine.evidence.plain) best = fine;
        }
        found.push_back(best);
    }
    std::stable_sort(found.begin(), found.end(), plainer);
}

}  // namespace roomfix
