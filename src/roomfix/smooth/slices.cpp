#include "roomfix/smooth/slices.hpp"

#include <algorithm>

namespace roomfix {
namespace {

constexpr std::size_t most_knots = 8;  // in a slice: the cost of the covariance grows with their square

}  // namespace

std::vector<double> way_along(const Trajectory& trajectory) {
    constexpr Nanoseconds apart = 1'000'000'000;
    std::vector<double> way(trajectory.knots.size(), 0);
    Nanoseconds from = trajectory.start();
    double before = 0;
    std::size_t k = 0;
    while (k < way.size()) {
        const Nanoseconds to = std::min(from + apart, trajectory.end());
        const double length = (trajectory.at(to) - trajectory.at(from)).head<2>().norm();
        for (; k < way.size() && trajectory.times[k] <= to; ++k) {
            way[k] = before + (to > from ? length * to_seconds(trajectory.times[k] - from) / to_seconds(to - from) : 0);
        }
        before += length;
        from = to;
    }
    return way;
}

Slices::Slices(const Trajectory& trajectory, const ChangeRate& fastest) {
    const std::vector<double> way = way_along(trajectory);
    const bool fast = fastest.per_second > 0 || fastest.per_metre > 0;
    for (std::size_t k = 0; k < way.size(); ++k) {
        const auto is_over = [&] {
            const double seconds = to_seconds(trajectory.times[k] - starts_.back());
            return !fast || k - first_knots_.back() >= most_knots ||
                   seconds * fastest.per_second + (way[k] - metres_.back()) * fastest.per_metre > part_of_memory;
        };
        if (k == 0 || is_over()) {
            first_knots_.push_back(k);
            starts_.push_back(trajectory.times[k]);
            metres_.push_back(way[k]);
        }
    }
}

std::size_t Slices::at(Nanoseconds time) const {
    const auto after = std::upper_bound(starts_.begin(), starts_.end(), time);
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - starts_.begin() - 1, 0));
}

double Slices::age(std::size_t from, std::size_t to, const ChangeRate& rate) const {
    return to_seconds(starts_[to] - starts_[from]) * rate.per_second + (metres_[to] - metres_[from]) * rate.per_metre;
}

}  // namespace roomfix
