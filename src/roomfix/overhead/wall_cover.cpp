#include "roomfix/overhead/wall_cover.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace roomfix {
namespace {

constexpr double own_wall = 0.3;  // m from the camera
constexpr double endless = 1e9;

/// The floor as the camera sees a place: along the line of sight and to its right, m.
struct Sight {
    Eigen::Vector2d from, ahead, right;
    double distance = 0;

    Sight(const Eigen::Vector2d& camera, const Eigen::Vector2d& place) : from(camera), distance((place - camera).norm()) {
        ahead = (place - camera) / std::max(distance, 1e-9);
        right = {ahead.y(), -ahead.x()};
    }
    Eigen::Vector2d of(const Eigen::Vector2d& point) const { return {ahead.dot(point - from), right.dot(point - from)}; }
};

/// A part of the circle of sight, as tangents from the line of sight.
struct Part {
    double low = 0, high = 0;
};

/// What a piece of wall before the place hides.
std::optional<Part> hidden_part(const Sight& sight, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    Eigen::Vector2d p = sight.of(a);
    Eigen::Vector2d q = sight.of(b);
    if (p.x() > q.x()) std::swap(p, q);
    if (q.x() <= own_wall || p.x() >= sight.distance) return std::nullopt;
    const auto at = [&](double depth) { return Eigen::Vector2d(depth, p.y() + (q.y() - p.y()) * (depth - p.x()) / (q.x() - p.x())); };
    const Eigen::Vector2d near = p.x() < own_wall ? at(own_wall) : p;
    const Eigen::Vector2d far = q.x() > sight.distance ? at(sight.distance) : q;
    const double one = near.y() / near.x();
    const double other = far.y() / far.x();
    return Part{std::min(one, other), std::max(one, other)};
}

/// Calls `take(part)` for each part that walls hide within `reach` (a tangent) of the line of sight, until it says false.
template <class Take>
void each_hidden_part(const Sight& sight, std::span<const Polyline> walls, double reach, const Take& take) {
    for (const Polyline& wall : walls) {
        for (std::size_t i = 1; i < wall.size(); ++i) {
            const auto part = hidden_part(sight, wall[i - 1], wall[i]);
            if (part && part->high > -reach && part->low < reach && !take(*part)) return;
        }
    }
}

bool any_within(const Sight& sight, std::span<const Polyline> walls, double reach) {
    bool any = false;
    each_hidden_part(sight, walls, reach, [&](const Part&) {
        any = true;
        return false;
    });
    return any;
}

/// The image of an upright line that is seen in a direction, at the distance of the place.
std::optional<WallCover::Line> image_of(const View& view, const Sight& sight, double tangent, double height, int scale) {
    const Eigen::Vector2d foot = sight.from + sight.distance * (sight.ahead + tangent * sight.right);
    const auto below = project_map_point(view, {foot.x(), foot.y(), 0});
    const auto above = project_map_point(view, {foot.x(), foot.y(), height});
    if (!below || !above || std::abs(below->y() - above->y()) < 1) return std::nullopt;
    const double per_row = (below->x() - above->x()) / (below->y() - above->y());
    const double middle = 0.5 * (scale - 1);
    const double row = (below->y() - middle) / scale;
    return WallCover::Line{(below->x() - middle) / scale - per_row * row, per_row};
}

/// Pieces of walls that meet, or hide parts that overlap, hide one stretch.
void join(std::vector<Part>& parts) {
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.low < b.low; });
    std::size_t last = 0;
    for (std::size_t i = 1; i < parts.size(); ++i) {
        if (parts[i].low <= parts[last].high + 1e-9) {
            parts[last].high = std::max(parts[last].high, parts[i].high);
        } else {
            parts[++last] = parts[i];
        }
    }
    if (!parts.empty()) parts.resize(last + 1);
}

}  // namespace

WallCover wall_cover(const View& view, std::span<const Polyline> walls, const Eigen::Vector2d& place, double radius, double height, int scale) {
    WallCover cover;
    const Sight sight(view.position().head<2>(), place);
    if (sight.distance < own_wall + radius) return cover;
    const double reach = radius / std::sqrt(sight.distance * sight.distance - radius * radius);
    thread_local std::vector<Part> parts;
    parts.clear();
    each_hidden_part(sight, walls, reach, [&](const Part& part) {
        parts.push_back(part);
        return true;
    });
    join(parts);
    for (const Part& part : parts) {
        if (part.low <= -reach && part.high >= reach) {
            cover.whole = true;
            return cover;
        }
        const auto from = part.low <= -reach ? WallCover::Line{-endless} : image_of(view, sight, part.low, height, scale);
        const auto to = part.high >= reach ? WallCover::Line{endless} : image_of(view, sight, part.high, height, scale);
        if (from && to && cover.stretches.size() < 6) cover.stretches.push_back({*from, *to});
    }
    return cover;
}

bool in_plain_view(const View& view, std::span<const Polyline> walls, const Eigen::Vector2d& place, double radius) {
    Sight sight(view.position().head<2>(), place);
    if (sight.distance < own_wall + radius) return false;
    const double reach = radius / std::sqrt(sight.distance * sight.distance - radius * radius);
    sight.distance += radius;
    return !any_within(sight, walls, reach);
}

bool behind_wall(const View& view, std::span<const Polyline> walls, const Eigen::Vector2d& place, double beside) {
    constexpr double touching = 0.1;  // m: what stands at a wall may seem to stand in it
    Sight sight(view.position().head<2>(), place);
    sight.distance -= touching;
    return any_within(sight, walls, beside);
}

void take_away(const WallCover& hidden, BodyMask& mask) {
    for (const WallCover::Stretch& stretch : hidden.stretches) {
        const std::size_t before = mask.spans.size();
        for (std::size_t i = 0; i < before; ++i) {
            const Span span = mask.spans[i];
            const auto column = [&](const WallCover::Line& line) {
                return static_cast<int>(std::lround(std::clamp(line.at(span.y), static_cast<double>(span.begin), static_cast<double>(span.end))));
            };
            const int from = column(stretch.from);
            const int to = column(stretch.to);
            if (from >= to) continue;
            mask.area -= (to - from) * mask.row_step;
            mask.spans[i] = from > span.begin ? Span{span.y, span.begin, from} : Span{span.y, to, span.end};
            if (from > span.begin && to < span.end) mask.spans.push_back({span.y, to, span.end});
        }
    }
    std::erase_if(mask.spans, [](const Span& span) { return span.begin >= span.end; });
}

}  // namespace roomfix
