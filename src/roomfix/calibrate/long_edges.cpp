#include "roomfix/calibrate/long_edges.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "roomfix/imaging/edge_points.hpp"

namespace roomfix {
namespace {

Eigen::Vector2d place_of(const EdgePoint& p) { return {p.x, p.y}; }
Eigen::Vector2d normal_of(const EdgePoint& p) { return {p.nx, p.ny}; }

/// Edge points by the cell of 2 x 2 px that they are in.
class PointMap {
public:
    explicit PointMap(const std::vector<EdgePoint>& points) : points_(points) {
        for (std::size_t i = 0; i < points.size(); ++i) cells_[cell(place_of(points[i]))].push_back(i);
    }
    /// The point nearest to a place, within `reach` px, with about this normal, that is still free.
    std::optional<std::size_t> nearest(const Eigen::Vector2d& place, const Eigen::Vector2d& normal, double reach, const std::vector<char>& taken) const {
        constexpr double same_direction = 0.94;
        std::optional<std::size_t> best;
        double least = reach;
        const int steps = static_cast<int>(std::ceil(reach / size));
        for (int dy = -steps; dy <= steps; ++dy) {
            for (int dx = -steps; dx <= steps; ++dx) {
                const auto in = cells_.find(cell(place + size * Eigen::Vector2d(dx, dy)));
                if (in == cells_.end()) continue;
                for (const std::size_t i : in->second) {
                    const EdgePoint& p = points_[i];
                    if (taken[i] || normal_of(p).dot(normal) < same_direction) continue;
                    const double distance = (place_of(p) - place).norm();
                    if (distance >= least) continue;
                    least = distance;
                    best = i;
                }
            }
        }
        return best;
    }

    /// Takes the points beside one that was taken: the same edge is not followed twice.
    void take_beside(const EdgePoint& point, std::vector<char>& taken) const {
        while (const auto beside = nearest(place_of(point), normal_of(point), beside_reach, taken)) taken[*beside] = 1;
    }

private:
    static constexpr double beside_reach = 1.8;  // px
    static constexpr double size = 2;            // px
    static std::pair<int, int> cell(const Eigen::Vector2d& p) {
        return {static_cast<int>(std::floor(p.x() / size)), static_cast<int>(std::floor(p.y() / size))};
    }
    const std::vector<EdgePoint>& points_;
    std::map<std::pair<int, int>, std::vector<std::size_t>> cells_;
};

/// Follows the edge from a point, to the left of its brighter side (sign 1) or to the right.
std::vector<std::size_t> follow(const std::vector<EdgePoint>& points, const PointMap& map, std::size_t from, double sign, std::vector<char>& taken) {
    constexpr double step = 1, reach = 0.9;  // px
    std::vector<std::size_t> chain;
    Eigen::Vector2d at = place_of(points[from]);
    Eigen::Vector2d normal = normal_of(points[from]);
    for (int missed = 0; missed < 5;) {
        const Eigen::Vector2d along = sign * Eigen::Vector2d(-normal.y(), normal.x());
        const Eigen::Vector2d expected = at + step * along;
        const auto next = map.nearest(expected, normal, reach, taken);
        if (!next) {
            at = expected;
            ++missed;
            continue;
        }
        missed = 0;
        taken[*next] = 1;
        chain.push_back(*next);
        at = place_of(points[*next]);
        // Its own direction is noisy; that of the last stretch is not.
        constexpr std::size_t stretch = 12;
        normal = (0.9 * normal + 0.1 * normal_of(points[*next])).normalized();
        if (chain.size() > stretch) {
            const Eigen::Vector2d way = (at - place_of(points[chain[chain.size() - 1 - stretch]])).normalized() * sign;
            normal = (normal + Eigen::Vector2d(way.y(), -way.x())).normalized();
        }
    }
    return chain;
}

double length_of(const LongEdge& edge) { return (edge.points.back() - edge.points.front()).norm(); }

/// Angle between the directions of the first and the last third.
double turn_of(const LongEdge& edge) {
    const std::size_t third = edge.points.size() / 3;
    const Eigen::Vector2d a = edge.points[third] - edge.points.front(), b = edge.points.back() - edge.points[edge.points.size() - 1 - third];
    return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
}

}  // namespace

std::vector<LongEdge> long_edges(LumaView picture, std::size_t number, const LongEdgeSettings& settings) {
    EdgePointFinder finder({.working_width = std::max(picture.width, 1), .threshold = 5, .least_gradient = 2, .most_points = 60000});
    std::vector<EdgePoint> points;
    finder.find(picture, points);
    std::vector<std::size_t> order(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return points[a].strength > points[b].strength; });
    const PointMap map(points);
    std::vector<char> taken(points.size(), 0);
    std::vector<LongEdge> edges;
    for (const std::size_t start : order) {
        if (taken[start]) continue;
        taken[start] = 1;
        const auto one_way = follow(points, map, start, 1, taken), other_way = follow(points, map, start, -1, taken);
        std::vector<std::size_t> chain(other_way.rbegin(), other_way.rend());
        chain.push_back(start);
        chain.insert(chain.end(), one_way.begin(), one_way.end());
        LongEdge edge;
        edge.picture = number;
        for (const std::size_t i : chain) {
            edge.points.push_back(place_of(points[i]));
            map.take_beside(points[i], taken);
        }
        if (edge.points.size() < least_edge_points || length_of(edge) < settings.least_length * picture.width || turn_of(edge) > settings.largest_turn)
            continue;
        edges.push_back(std::move(edge));
    }
    return edges;
}

std::vector<LongEdge> without_repeats(std::vector<LongEdge> edges) {
    constexpr double same = 4;  // px
    const auto covers = [&](const LongEdge& longer, const LongEdge& edge) {
        for (const std::size_t i : {std::size_t{0}, edge.points.size() / 2, edge.points.size() - 1}) {
            const bool near =
                std::any_of(longer.points.begin(), longer.points.end(), [&](const Eigen::Vector2d& p) { return (p - edge.points[i]).norm() < same; });
            if (!near) return false;
        }
        return true;
    };
    std::stable_sort(edges.begin(), edges.end(), [](const LongEdge& a, const LongEdge& b) { return a.points.size() > b.points.size(); });
    std::vector<LongEdge> kept;
    for (LongEdge& edge : edges) {
        const bool known = std::any_of(kept.begin(), kept.end(), [&](const LongEdge& k) { return k.picture != edge.picture && covers(k, edge); });
        if (!known) kept.push_back(std::move(edge));
    }
    return kept;
}

}  // namespace roomfix
