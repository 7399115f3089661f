#include "roomfix/geometry/convex_hull.hpp"

#include <algorithm>

namespace roomfix {
namespace {

double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool before(const Eigen::Vector2d& p, const Eigen::Vector2d& q) { return p.x() != q.x() ? p.x() < q.x() : p.y() < q.y(); }

/// Of points in this order.
int hull_in_order(std::span<const Eigen::Vector2d> points, std::span<const int> order, std::span<int> hull) {
    const int count = static_cast<int>(points.size());
    if (count < 3) {
        std::copy_n(order.begin(), count, hull.begin());
        return count;
    }
    int size = 0;
    const auto at = [&](int i) -> const Eigen::Vector2d& { return points[static_cast<std::size_t>(hull[static_cast<std::size_t>(i)])]; };
    const auto push = [&](int index, int floor) {
        while (size >= floor && turn(at(size - 2), at(size - 1), points[static_cast<std::size_t>(index)]) <= 0) --size;
        hull[static_cast<std::size_t>(size++)] = index;
    };
    for (int i = 0; i < count; ++i) push(order[static_cast<std::size_t>(i)], 2);
    const int upper = size + 1;
    for (int i = count - 2; i >= 0; --i) push(order[static_cast<std::size_t>(i)], upper);
    return size - 1;
}

}  // namespace

int convex_hull(std::span<const Eigen::Vector2d> points, std::span<int> order, std::span<int> hull) {
    const int count = static_cast<int>(points.size());
    for (int i = 0; i < count; ++i) order[static_cast<std::size_t>(i)] = i;
    std::sort(order.begin(), order.begin() + count,
              [&](int a, int b) { return before(points[static_cast<std::size_t>(a)], points[static_cast<std::size_t>(b)]); });
    return hull_in_order(points, order, hull);
}

void sort_nearly_sorted(std::span<Eigen::Vector2d> points) {
    for (std::size_t i = 1; i < points.size(); ++i) {
        const Eigen::Vector2d moving = points[i];
        std::size_t to = i;
        for (; to > 0 && before(moving, points[to - 1]); --to) points[to] = points[to - 1];
        points[to] = moving;
    }
}

int convex_hull_of_sorted(std::span<const Eigen::Vector2d> points, std::span<Eigen::Vector2d> hull) {
    if (points.size() < 3) {
        std::copy(points.begin(), points.end(), hull.begin());
        return static_cast<int>(points.size());
    }
    std::size_t size = 0;
    const auto push = [&](const Eigen::Vector2d& point, std::size_t floor) {
        while (size >= floor && turn(hull[size - 2], hull[size - 1], point) <= 0) --size;
        hull[size++] = point;
    };
    for (const Eigen::Vector2d& point : points) push(point, 2);
    const std::size_t upper = size + 1;
    for (std::size_t i = points.size() - 1; i-- > 0;) push(points[i], upper);
    return static_cast<int>(size) - 1;
}

std::vector<Eigen::Vector2d> hull_of(const std::vector<Eigen::Vector2d>& points) {
    std::vector<int> order(points.size() + 1);
    std::vector<int> hull(points.size() + 1);
    const int corners = convex_hull(points, order, hull);
    std::vector<Eigen::Vector2d> result;
    for (int i = 0; i < corners; ++i) result.push_back(points[static_cast<std::size_t>(hull[static_cast<std::size_t>(i)])]);
    return result;
}

}  // namespace roomfix
