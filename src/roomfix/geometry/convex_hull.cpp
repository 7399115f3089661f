#include "roomfix/geometry/convex_hull.hpp"

#include <algorithm>

namespace roomfix {
namespace {

double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

}  // namespace

int convex_hull(std::span<const Eigen::Vector2d> points, std::span<int> order, std::span<int> hull) {
    const int count = static_cast<int>(points.size());
    for (int i = 0; i < count; ++i) order[static_cast<std::size_t>(i)] = i;
    std::sort(order.begin(), order.begin() + count, [&](int a, int b) {
        const auto& p = points[static_cast<std::size_t>(a)];
        const auto& q = points[static_cast<std::size_t>(b)];
        return p.x() != q.x() ? p.x() < q.x() : p.y() < q.y();
    });
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

std::vector<Eigen::Vector2d> hull_of(const std::vector<Eigen::Vector2d>& points) {
    std::vector<int> order(points.size() + 1);
    std::vector<int> hull(points.size() + 1);
    const int corners = convex_hull(points, order, hull);
    std::vector<Eigen::Vector2d> result;
    for (int i = 0; i < corners; ++i) result.push_back(points[static_cast<std::size_t>(hull[static_cast<std::size_t>(i)])]);
    return result;
}

}  // namespace roomfix
