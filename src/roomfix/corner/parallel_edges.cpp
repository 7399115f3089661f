#include "roomfix/corner/parallel_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "roomfix/base/median.hpp"

namespace roomfix {
namespace {

constexpr double beside = 2.25;  // px: light on either side of a step is averaged up to here

struct StepAt {
    double place = 0;       // px from the stretch
    double plain = 0;       // standard deviations
    bool brighter = false;  // along the stretch's normal
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
    const double noise = std::max(static_cast<double>(median(bends)) / (0.6745 * std::sqrt(6.0)), 0.05);
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
        if (steps.size() < 32) steps.push_back({static_cast<double>(values[i].distance) + shift * LightProfile::bin, size, change[i] > 0});
    }
}

}  // namespace

BesideVotes::BesideVotes(const std::array<double, 2>& lift, double unit, const ParallelSettings& settings)
    : settings_(settings), lift_(lift), unit_(unit), rise_step_(step / std::max(lift[0], lift[1])) {}

void BesideVotes::add(const CornerFit& fit, int k) {
    const double raised = rise(k);
    FixedList<StepAt, 32> steps;
    for (const EdgePiece& piece : fit.pieces) {
        if (piece.edge == wall_edge || piece.start > settings_.far * unit_ || piece.profile.values.size() < 16 || std::abs(piece.lift) < 1e-9) continue;
        const bool near = piece.start < settings_.near * unit_;
        Length& length = read_[piece.edge][static_cast<std::size_t>(k + most)];
        length.all += piece.length;
        if (near) length.near += piece.length;
        steps_in(piece.profile, settings_.plain, steps);
        std::array<std::array<bool, cells>, 2> counted{};  // a piece counts once
        for (const StepAt& at : steps) {
            const double further = (1 + raised) * at.place / piece.lift;
            if (std::abs(further) > 0.5 * rise_step_) continue;  // another fit reads it better
            const int middle = static_cast<int>(std::lround((raised + further) * lift_[piece.edge])) + reach;
            const std::size_t sign = at.brighter == (piece.lift > 0);
            for (int cell = std::max(middle - 1, 0); cell <= std::min(middle + 1, cells - 1); ++cell) {
                const auto c = static_cast<std::size_t>(cell);
                if (counted[sign][c]) continue;
                counted[sign][c] = true;
                votes_[piece.edge][sign].all[c] += piece.length;
                if (near) votes_[piece.edge][sign].near[c] += piece.length;
            }
        }
    }
}

/// Whether an edge runs there along this part of what could be read.
bool BesideVotes::holds(std::size_t edge, int cell, double part) const {
    const int k = static_cast<int>(std::lround((cell - reach) / (rise_step_ * lift_[edge])));
    if (std::abs(k) > most) return false;
    const Length& length = read_[edge][static_cast<std::size_t>(k + most)];
    if (length.near < 0.5 * settings_.near * unit_ || length.all < settings_.near * unit_) return false;
    // Posters and cupboards draw edges below the ceiling's, and begin away from the corner; nothing but a moulding does above it, but faintly, where all is
    // white.
    const bool above = cell > reach;
    const double least_near = above ? 0 : part * length.near;
    const double least = (above ? 0.8 : 1) * part * length.all;
    const auto c = static_cast<std::size_t>(cell);
    return std::any_of(votes_[edge].begin(), votes_[edge].end(), [&](const Row& row) { return row.near[c] >= least_near && row.all[c] > least; });
}

/// The outermost rise above (direction 1) or below (-1) the edge at which one runs, its size between `from` and `to`; 0: none.
double BesideVotes::outermost(std::size_t edge, int direction, double part, double from, double to) const {
    const int nearest = std::max(static_cast<int>(settings_.apart * unit_), static_cast<int>(from * lift_[edge]));
    const int farthest = std::min(reach, static_cast<int>(to * lift_[edge]));
    for (int off = farthest; off >= nearest; --off) {
        if (!holds(edge, reach + direction * off, part)) continue;
        // Each step counts in three cells.
        const int middle = off - 1 >= nearest && holds(edge, reach + direction * (off - 1), part) ? off - 1 : off;
        return direction * middle / lift_[edge];
    }
    return 0;
}

EdgesBeside BesideVotes::found() const {
    EdgesBeside edges;
    for (const int direction : {1, -1}) {
        auto& rises = direction > 0 ? edges.above : edges.below;
        for (std::size_t edge = 0; edge < 2; ++edge) rises[edge] = outermost(edge, direction, settings_.kept, 0, 1);
        for (std::size_t edge = 0; edge < 2; ++edge) {
            const double other = std::abs(rises[1 - edge]);
            if (rises[edge] == 0 && other > 0) rises[edge] = outermost(edge, direction, settings_.second, 0.4 * other, 2.5 * other);
        }
    }
    return edges;
}

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
