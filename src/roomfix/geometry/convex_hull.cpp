#include "roomfix/geometry/convex_hull.hpp"

#include <algorithm>

namespace roomfix {
namespace {

double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool before(const Eigen::Vector2d& p, const Eigen::Vector2d& q) { return p.x() != q.x() ? p.x() < q.x() : p.y() < q.y(); }

/// The hull of items from left to right; `point_of` gives the place of one.
template <class Item, class PointOf>
int hull_in_order(std::span<const Item> items, std::span<Item> hull, const PointOf& point_of) {
    if (items.size() < 3) {
        std::copy(items.begin(), items.end(), hull.begin());
        return static_cast<int>(items.size());
    }
    std::size_t size = 0;
    const auto push = [&](const Item& item, std::size_t floor) {
        while (size >= floor && turn(point_of(hull[size - 2]), point_of(hull[size - 1]), point_of(item)) <= 0) --size;
        hull[size++] = item;
    };
    for (const Item& item : items) push(item, 2);
    const std::size_t upper = size + 1;
    for (std::size_t i = items.size() - 1; i-- > 0;) push(items[i], upper);
    return static_cast<int>(size) - 1;
}

}  // namespace

int convex_hull(std::span<const Eigen::Vector2d> points, std::span<int> order, std::span<int> hull) {
    const int count = static_cast<int>(points.size());
    for (int i = 0; i < count; ++i) order[static_cast<std::size_t>(i)] = i;
    std::sort(order.begin(), order.begin() + count,
              [&](int a, int b) { return before(points[static_cast<std::size_t>(a)], points[static_cast<std::size_t>(b)]); });
    return hull_in_order(std::span<const int>(order.data(), points.size()), hull,
                         [&](int index) -> const Eigen::Vector2d& { return points[static_cast<std::size_t>(index)]; });
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
    return hull_in_order(points, hull, [](const Eigen::Vector2d& point) -> const Eigen::Vector2d& { return point; });
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
