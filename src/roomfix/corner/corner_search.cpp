#include "roomfix/corner/corner_search.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

bool starts_edges(const CornerJunction& junction, const CornerRays& rays, double tolerance) {
    const auto along = [&](std::size_t line, CornerEdge edge) { return junction.directions[line].dot(rays.directions[edge]) > std::cos(tolerance); };
    return (along(0, x_edge) && along(1, y_edge)) || (along(1, x_edge) && along(0, y_edge));
}

CornerSearch::CornerSearch(const CameraModel& model, const std::vector<double>& wall_angles, const CornerSearchSettings& settings)
    : model_(model), wall_angles_(wall_angles), settings_(settings), focal_(0.5 * (model.fx + model.fy)) {
    const double unit = length_unit(model);
    settings_.meeting = std::max(settings_.meeting * unit, 2.5);
    settings_.near_corner *= unit;
}

/// The side of a line that starts at `point`; nothing if neither does.
std::optional<CornerSearch::HalfLine> CornerSearch::half_line(const SceneLine& line, const Eigen::Vector2d& point) const {
    const double at = line.along().dot(point);
    const double near = settings_.near_corner / focal_;
    const double gap = 1.5 * line.cell;
    const double far = 100;  // beyond any picture
    std::optional<HalfLine> best;
    for (const double sign : {1.0, -1.0}) {
        HalfLine half;
        half.sign = sign;
        half.covered = line.covered(at, at + sign * far);
        half.near_part = line.covered(at, at + sign * near) / near;
        half.beyond = line.covered(at - sign * gap, at - sign * (gap + near)) / near;
        if (half.near_part > settings_.least_near && (!best || half.covered > best->covered)) best = half;
    }
    return best;
}

double CornerSearch::score_of(const HalfLine& half) const {
    return half.covered * focal_ * std::min(1.0, half.near_part + 0.3) - 0.7 * half.beyond * settings_.near_corner;
}

bool CornerSearch::in_picture(const Eigen::Vector2d& point) const {
    const auto pixel = project(model_, point.homogeneous());
    return pixel && model_.contains(*pixel, settings_.border);
}

void CornerSearch::try_triple(const std::vector<SceneLine>& lines, const std::array<int, 3>& which, const std::optional<Gravity>& gravity,
                              std::vector<CornerCandidate>& candidates) const {
    // The point nearest to all three lines.
    Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (const int i : which) {
        const SceneLine& line = lines[static_cast<std::size_t>(i)];
        square += line.normal * line.normal.transpose();
        right += line.distance * line.normal;
    }
    CornerRays rays;
    rays.corner = square.inverse() * right;
    if (!in_picture(rays.corner)) return;
    double score = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const SceneLine& line = lines[static_cast<std::size_t>(which[i])];
        if (std::abs(line.normal.dot(rays.corner) - line.distance) * focal_ > settings_.meeting) return;
        const auto half = half_line(line, rays.corner);
        if (!half) return;
        rays.directions[i] = half->sign * line.along();
        score += score_of(*half);
    }
    add_solutions(rays, EdgeKind::step, score, which, gravity, candidates);
}

void CornerSearch::add_solutions(const CornerRays& rays, EdgeKind third, double score, const std::array<int, 3>& which, const std::optional<Gravity>& gravity,
                                 std::vector<CornerCandidate>& candidates) const {
    for (std::size_t i = 0; i < 3; ++i) {
        if (rays.directions[i].dot(rays.directions[(i + 1) % 3]) > std::cos(radians(settings_.least_angle))) return;
    }
    const auto upright = [&](const Eigen::Vector3d& down) {
        if (gravity) return std::acos(std::clamp(down.dot(gravity->down), -1.0, 1.0)) < 5 * gravity->sigma + 0.02;
        // A camera that looks nearly straight up may be turned in any way.
        return std::atan2(std::abs(down.x()), down.y()) < radians(settings_.steepest) || std::hypot(down.x(), down.y()) < 0.12;
    };
    const auto all = labellings(rays);
    for (std::size_t walls_edge = third == EdgeKind::crease ? 2 : 0; walls_edge < 3; ++walls_edge) {
        const CornerRays& labelled = all[walls_edge];
        for (const double angle : wall_angles_) {
            const CornerSolutions solutions = solve_corner(labelled, angle);
            for (int s = 0; s < solutions.count; ++s) {
                const CornerView& view = solutions.views[static_cast<std::size_t>(s)];
                const Eigen::Vector3d down = -view.corner_from_camera.row(2).transpose();
                if (view.place.norm() < settings_.farthest && upright(down)) candidates.push_back({view, angle, score, which, third});
            }
        }
    }
}

void CornerSearch::find(const std::vector<SceneLine>& lines, const std::optional<Gravity>& gravity, CornerSearchResult& result) const {
    result.candidates.clear();
    result.junctions.clear();
    const int count = static_cast<int>(lines.size());
    const double least_cross = std::sin(radians(settings_.least_angle));
    for (int i = 0; i < count; ++i) {
        for (int j = i + 1; j < count; ++j) {
            const SceneLine& a = lines[static_cast<std::size_t>(i)];
            const SceneLine& b = lines[static_cast<std::size_t>(j)];
            const double cross = a.normal.x() * b.normal.y() - a.normal.y() * b.normal.x();
            if (std::abs(cross) < least_cross) continue;
            const Eigen::Vector2d meeting((a.distance * b.normal.y() - b.distance * a.normal.y()) / cross,
                                          (b.distance * a.normal.x() - a.distance * b.normal.x()) / cross);
            const auto half_a = half_line(a, meeting);
            if (!half_a) continue;
            const auto half_b = half_line(b, meeting);
            if (!half_b || !in_picture(meeting)) continue;
            result.junctions.push_back({meeting, {half_a->sign * a.along(), half_b->sign * b.along()}, score_of(*half_a) + score_of(*half_b), {i, j}});
            for (int k = j + 1; k < count; ++k) {
                const SceneLine& c = lines[static_cast<std::size_t>(k)];
                if (std::abs(c.normal.dot(meeting) - c.distance) * focal_ < 2 * settings_.meeting) try_triple(lines, {i, j, k}, gravity, result.candidates);
            }
        }
    }
    const auto better = [](const auto& a, const auto& b) { return a.score > b.score; };
    std::stable_sort(result.candidates.begin(), result.candidates.end(), better);
    if (result.candidates.size() > settings_.most) result.candidates.resize(settings_.most);
    std::stable_sort(result.junctions.begin(), result.junctions.end(), better);
    if (result.junctions.size() > settings_.most_junctions) result.junctions.resize(settings_.most_junctions);
}

/// Directions from the junction that a third edge could have and along which the light steps, the plainest first.
std::vector<Eigen::Vector2d> CornerSearch::faint_directions(LumaView frame, const LightTable& light, const FaintEdges& edges, EdgeKind kind,
                                                            const CornerJunction& junction, const std::optional<Gravity>& gravity) const {
    constexpr int directions = 240;
    constexpr double turn = 2 * std::numbers::pi / directions;
    constexpr int skip = 3;
    constexpr double softer = 3;  // so that no edge lies between two directions
    constexpr std::size_t most = 3;
    std::array<double, directions> plain{};
    std::vector<CornerCandidate> possible;
    for (int i = 0; i < directions; ++i) {
        const Eigen::Vector2d direction(std::cos(i * turn), std::sin(i * turn));
        possible.clear();
        add_solutions({junction.point, {junction.directions[0], junction.directions[1], direction}}, kind, 0, {0, 0, -1}, gravity, possible);
        if (!possible.empty()) plain[static_cast<std::size_t>(i)] = edges.along(frame, light, junction.point, direction, kind, skip, softer).plain;
    }
    std::vector<std::pair<double, int>> peaks;
    for (int i = 0; i < directions; ++i) {
        const auto at = [&](int offset) { return plain[static_cast<std::size_t>((i + offset + directions) % directions)]; };
        if (at(0) > settings_.faint && at(0) >= at(-1) && at(0) > at(1)) peaks.emplace_back(-at(0), i);
    }
    std::sort(peaks.begin(), peaks.end());
    if (peaks.size() > most) peaks.resize(most);
    std::vector<Eigen::Vector2d> found;
    std::vector<FaintEdges::Peak> fine;
    for (const auto& [strength, i] : peaks) {
        const Eigen::Vector2d direction(std::cos(i * turn), std::sin(i * turn));
        edges.peaks(frame, light, junction.point, direction, kind, 0.5 * turn, fine);
        if (!fine.empty()) found.push_back(Eigen::Rotation2Dd(fine[0].turn) * direction);
    }
    return found;
}

void CornerSearch::complete(LumaView frame, const LightTable& light, const FaintEdges& edges, EdgeKind kind, const std::optional<Gravity>& gravity,
                            CornerSearchResult& result) const {
    result.candidates.clear();
    for (const CornerJunction& junction : result.junctions) {
        for (const Eigen::Vector2d& third : faint_directions(frame, light, edges, kind, junction, gravity)) {
            const CornerRays rays{junction.point, {junction.directions[0], junction.directions[1], third}};
            add_solutions(rays, kind, junction.score, {junction.lines[0], junction.lines[1], -1}, gravity, result.candidates);
        }
    }
    if (result.candidates.size() > settings_.most) result.candidates.resize(settings_.most);
}

}  // namespace roomfix
