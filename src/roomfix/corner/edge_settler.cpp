#include "roomfix/corner/edge_settler.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace roomfix {

CornerEdge EdgeSettler::faintest(const CornerFit& fit) const {
    std::array<double, 3> sum{};
    std::array<double, 3> length{};
    const double group = settings_.light.piece * settings_.light.together;
    for (const EdgePiece& piece : fit.pieces) {
        length[piece.edge] += piece.length;
        if (!piece.read) continue;
        const double plain = piece.step.contrast / piece.step.contrast_sigma;
        sum[piece.edge] += piece.length * saturated(plain * plain * group / piece.length, settings_.light);
    }
    CornerEdge least = x_edge;
    for (const CornerEdge edge : {y_edge, wall_edge}) {
        if (sum[edge] * length[least] < sum[least] * length[edge]) least = edge;
    }
    return least;
}

SettledEdge EdgeSettler::settle(LumaView frame, double wall_angle, CornerEdge edge, EdgeKind kind, CornerView& view) {
    SettledEdge settled;
    const auto rays = corner_rays(view, wall_angle);
    if (!rays) return settled;
    const double group = settings_.light.piece * settings_.light.together;
    const auto mean = [&](const EdgeEvidence& e) { return e.plain * group / std::max(e.visible, group); };
    const EdgeEvidence own = edges_.along(frame, light_, rays->corner, rays->directions[edge], kind);
    settled.edge = edge;
    settled.beside = view;
    settled.mean = mean(own);
    if (settled.mean > settings_.plain_group) return settled;
    edges_.peaks(frame, light_, rays->corner, rays->directions[edge], kind, settings_.span, peaks_);
    if (peaks_.empty()) return settled;
    const bool other = peaks_[0].evidence.plain > settings_.plainer * own.plain;
    const double turn = other ? peaks_[0].turn : 0;
    const EdgeEvidence best = other ? peaks_[0].evidence : own;
    for (const FaintEdges::Peak& peak : peaks_) {
        const double part = peak.evidence.plain / std::max(best.plain, 1e-9);
        if (std::abs(peak.turn - turn) < settings_.apart || part < settled.rival) continue;
        settled.rival = part;
        settled.beside = turned(*rays, wall_angle, edge, peak.turn, view).value_or(view);
    }
    const auto moved = other ? turned(*rays, wall_angle, edge, turn, view) : std::nullopt;
    if (!moved) return settled;
    view = *moved;
    settled.moved = true;
    settled.mean = mean(best);
    return settled;
}

/// The view nearest to `view` in which the edge is turned.
std::optional<CornerView> EdgeSettler::turned(const CornerRays& rays, double wall_angle, CornerEdge edge, double turn, const CornerView& view) const {
    CornerRays other = rays;
    other.directions[edge] = Eigen::Rotation2Dd(turn) * other.directions[edge];
    const CornerSolutions solutions = solve_corner(other, wall_angle);
    std::optional<CornerView> nearest;
    double least = settings_.turn;
    for (int i = 0; i < solutions.count; ++i) {
        const CornerView& solution = solutions.views[static_cast<std::size_t>(i)];
        const double off = (solution.corner_from_camera - view.corner_from_camera).norm();
        if (off > least) continue;
        least = off;
        nearest = solution;
    }
    return nearest;
}

}  // namespace roomfix
