#include "roomfix/corner/parallel_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace roomfix {
namespace {

constexpr double beside = 2.25;  // px: light on either side of a step is averaged up to here

struct StepAt {
    double place = 0;  // px from the stretch
    double plain = 0;  // standard deviations
};

/// Where the light along a profile steps.
void steps_in(const LightProfile& profile, double plain, FixedList<StepAt, 32>& steps) {
    steps.clear();
    const auto& values = profile.values;
    const std::size_t count = values.size();
    if (count < 16) return;
    // Neighbouring bins differ by noise, apart from the few at a step.
    FixedList<float, LightProfile::most> bends;
    for (std::size_t i = 1; i + 1 < count; ++i) bends.push_back(std::abs(values[i + 1].light - 2 * values[i].light + values[i - 1].light));
    std::nth_element(bends.begin(), bends.begin() + static_cast<std::ptrdiff_t>(bends.size() / 2), bends.end());
    const double noise = std::max(static_cast<double>(bends[bends.size() / 2]) / (0.6745 * std::sqrt(6.0)), 0.05);
    std::array<double, LightProfile::most> change{};
    for (std::size_t i = 0; i < count; ++i) {
        const double here = static_cast<double>(values[i].distance);
        double left = 0, right = 0;
        int lefts = 0, rights = 0;
        for (std::size_t j = i; j-- > 0 && here - static_cast<double>(values[j].distance) <= beside;) {
            left += static_cast<double>(values[j].light);
            ++lefts;
        }
        for (std::size_t j = i + 1; j < count && static_cast<double>(values[j].distance) - here <= beside; ++j) {
            right += static_cast<double>(values[j].light);
            ++rights;
        }
        if (lefts < 3 || rights < 3) continue;
        change[i] = (right / rights - left / lefts) / (noise * std::sqrt(1.0 / lefts + 1.0 / rights));
    }
    for (std::size_t i = 2; i + 2 < count; ++i) {
        const double size = std::abs(change[i]);
        const auto smaller = [&](std::size_t j) { return std::abs(change[j]) <= size || change[j] * change[i] < 0; };
        if (size < plain || !smaller(i - 1) || !smaller(i + 1) || !smaller(i - 2) || !smaller(i + 2)) continue;
        const double before = std::abs(change[i - 1]);
        const double after = std::abs(change[i + 1]);
        const double bend = before - 2 * size + after;
        const double shift = bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
        if (steps.size() < 32) steps.push_back({static_cast<double>(values[i].distance) + shift * LightProfile::bin, size});
    }
}

}  // namespace

CornerView with_corner_raised(const CornerView& view, double rise) {
    CornerView raised = view;
    raised.place = view.place / (1 + rise);
    return raised;
}

double rise_of_corner_at(const CornerView& view, const Eigen::Vector2d& point) {
    const Eigen::Vector3d ray = view.corner_from_camera * point.homogeneous();
    return ray.z() * view.place.norm() / ray.head<2>().norm() - 1;
}

std::optional<double> moulding_between(const CameraModel& model, const CornerView& upper, const CornerView& lower, double wall_angle, double largest) {
    const auto above = corner_pixel(model, upper, wall_angle);
    const auto under = corner_pixel(model, lower, wall_angle);
    const auto rays = corner_rays(upper, wall_angle);
    if (!above || !under || !rays) return std::nullopt;
    const Eigen::Vector2d apart = *under - *above;
    const double drop = apart.dot(rays->directions[wall_edge]);
    const bool along_wall = std::sqrt(std::max(apart.squaredNorm() - drop * drop, 0.0)) < 0.4 * drop + 1;
    if (drop < 2 || drop > largest * model.height || !along_wall) return std::nullopt;
    return drop;
}

void find_parallel_corners(const CornerFit& fit, double height, const ParallelSettings& settings, std::vector<ParallelCorner>& corners) {
    corners.clear();
    // Raising the corner by r of its ceiling distance moves the camera down in its frame: the same as moving the edges up by r along z.
    constexpr int most = 512;
    const int above = std::min(static_cast<int>(settings.above * height / settings.cell), most / 2 - 2);
    const int below = std::min(static_cast<int>(settings.below * height / settings.cell), most / 2 - 2);
    std::array<std::array<double, most>, 2> votes{};
    double per_px = 0;  // rise that moves an edge by one px beside the corner
    for (const EdgePiece& piece : fit.pieces) {
        if (piece.edge != wall_edge) per_px = std::max(per_px, std::abs(piece.lift) > 1e-9 && piece.start < 40 ? 1 / std::abs(piece.lift) : 0.0);
    }
    if (!(per_px > 0)) return;
    FixedList<StepAt, 32> steps;
    for (const EdgePiece& piece : fit.pieces) {
        if (piece.edge == wall_edge || std::abs(piece.lift) < 1e-9) continue;
        steps_in(piece.profile, settings.plain, steps);
        for (const StepAt& step : steps) {
            const double cell = step.place / piece.lift / (per_px * settings.cell) + below;
            const int index = static_cast<int>(std::lround(cell));
            if (index < 1 || index > above + below - 1) continue;
            // A step counts by its length, spread over the error of its place.
            auto& row = votes[piece.edge];
            const double weight = piece.length * std::min(1.0, step.plain / 8);
            for (const int k : {-1, 0, 1}) row[static_cast<std::size_t>(index + k)] += weight * (k == 0 ? 0.5 : 0.35);
        }
    }
    std::array<double, most> both{};
    double best = 0;
    for (std::size_t i = 0; i <= static_cast<std::size_t>(above + below); ++i) {
        both[i] = std::min(votes[0][i], votes[1][i]);
        best = std::max(best, both[i]);
    }
    for (int i = 2; i + 2 <= above + below; ++i) {
        const auto at = [&](int j) { return both[static_cast<std::size_t>(j)]; };
        if (at(i) < settings.least * best || at(i) <= 0 || at(i) < at(i - 1) || at(i) <= at(i + 1) || at(i) < at(i - 2) || at(i) <= at(i + 2)) continue;
        const double bend = at(i - 1) - 2 * at(i) + at(i + 1);
        const double shift = bend < 0 ? std::clamp(0.5 * (at(i - 1) - at(i + 1)) / bend, -0.5, 0.5) : 0;
        corners.push_back({(i + shift - below) * per_px * settings.cell, at(i)});
    }
}

}  // namespace roomfix
