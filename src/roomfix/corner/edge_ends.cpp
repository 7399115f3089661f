#include "roomfix/corner/edge_ends.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "roomfix/corner/parallel_edges.hpp"

namespace roomfix {
namespace {

/// Light's step across an edge in the pieces next to the corner; 0 where none is seen.
double contrast_near_corner(const CornerFit& fit, CornerEdge edge) {
    constexpr int most = 4;
    double sum = 0;
    int count = 0;
    for (const EdgePiece& piece : fit.pieces) {
        if (piece.edge != edge || !piece.seen || count == most) continue;
        sum += piece.step.contrast;
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

/// Does an edge of contrast `mean` go on where `step` was read, with `least` of it or more? It must stand out by `plain` standard deviations.
bool goes_on(const EdgeStep& step, double mean, double plain, double least = 0.7) {
    const double ratio = step.contrast / mean;
    return ratio > least && ratio < 1.6 && std::abs(step.contrast) > plain * step.contrast_sigma && std::abs(step.offset) < 1.5;
}

}  // namespace

bool EdgeEnds::continues_above(LumaView frame, const CornerFit& lower, double wall_angle, double rise) const {
    const auto pixel = corner_pixel(model_, lower.view, wall_angle);
    const auto upper = corner_pixel(model_, with_corner_raised(lower.view, rise), wall_angle);
    if (!pixel || !upper) return false;
    const double mean = contrast_near_corner(lower, wall_edge);
    if (mean == 0) return false;
    // The pieces run down from the corner, this stretch down to it.
    LightProfile profile;
    EdgeStep step;
    const LineStretch between{*upper + 0.15 * (*pixel - *upper), *pixel - 0.15 * (*pixel - *upper)};
    const bool crease = lower.kind[wall_edge] == EdgeKind::crease;
    const EdgeLook& look = lower.look[wall_edge];
    const double reach = crease ? look.reach * look.blur : 5;
    const StepModel model = crease ? StepModel::crease : StepModel::coarse;
    if (!read_profile(frame, light_, between, reach, 1, profile) || !fit_step(profile, look.blur, reach, model, step)) return false;
    return goes_on(step, mean, settings_.plainly_above);
}

bool EdgeEnds::end_at_corner(LumaView frame, const CornerFit& fit, double wall_angle) const {
    const auto rays = corner_rays(fit.view, wall_angle);
    if (!rays) return false;
    const double focal = 0.5 * (model_.fx + model_.fy);
    LightProfile profile;
    EdgeStep step;
    for (const CornerEdge edge : {x_edge, y_edge}) {
        const double mean = contrast_near_corner(fit, edge);
        if (mean == 0) continue;
        const auto pixel_beyond = [&](double px) { return project(model_, (rays->corner - rays->directions[edge] * (px / focal)).eval().homogeneous()); };
        const auto read = [&](double near, double far) {
            const auto from = pixel_beyond(near);
            const auto to = pixel_beyond(far);
            if (!from || !to || !model_.contains(*from, 6) || !model_.contains(*to, 6)) return false;
            return read_profile(frame, light_, {*to, *from}, 5, 1, profile) && fit_step(profile, fit.look[edge].blur, 5, StepModel::coarse, step);
        };
        if (!read(settings_.beyond_from, settings_.beyond_to)) continue;
        if (goes_on(step, mean, settings_.plainly_beyond)) return false;
        const auto goes_on_in_shadow = [&] { return goes_on(step, mean, settings_.plainly_beyond, settings_.in_shadow); };
        if (goes_on_in_shadow() && read(settings_.beyond_to, settings_.far_beyond) && goes_on_in_shadow()) return false;
    }
    return true;
}

}  // namespace roomfix
