#include "roomfix/corner/line_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace roomfix {
namespace {

constexpr int grid = 8;      // px
constexpr int angles = 360;  // one per degree, directed
const std::array<Eigen::Vector2f, angles> directions = [] {
    std::array<Eigen::Vector2f, angles> table;
    for (int i = 0; i < angles; ++i) {
        const double a = i * 2 * std::numbers::pi / angles;
        table[static_cast<std::size_t>(i)] = {static_cast<float>(std::cos(a)), static_cast<float>(std::sin(a))};
    }
    return table;
}();

}  // namespace

double SceneLine::covered(double from, double to) const {
    if (from > to) std::swap(from, to);
    const int low = std::clamp(static_cast<int>(std::floor((from - first) / cell)), 0, cells);
    const int high = std::clamp(static_cast<int>(std::ceil((to - first) / cell)), 0, cells);
    return cell * (filled[static_cast<std::size_t>(high)] - filled[static_cast<std::size_t>(low)]);
}

std::array<Eigen::Vector2d, 2> SceneLine::ends() const {
    const auto at = [&](int border) { return (normal * distance + along() * (first + border * cell)).eval(); };
    return {at(first_filled), at(last_filled + 1)};
}

LineSearch::LineSearch(const CameraModel& model, const LineSearchSettings& settings) : model_(model), settings_(settings), focal_(0.5 * (model.fx + model.fy)) {
    grid_across_ = (model.width + grid - 1) / grid + 1;
    grid_down_ = (model.height + grid - 1) / grid + 1;
    double widest = 0;
    for (int j = 0; j < grid_down_; ++j) {
        for (int i = 0; i < grid_across_; ++i) {
            const auto ray = unproject(model, {static_cast<double>(i * grid), static_cast<double>(j * grid)});
            const float none = std::numeric_limits<float>::quiet_NaN();
            straight_.push_back(ray ? Eigen::Vector2f((focal_ * *ray).cast<float>()) : Eigen::Vector2f(none, none));
            if (ray) widest = std::max(widest, focal_ * ray->norm());
        }
    }
    // Far outside, a fisheye's border would need a picture of any size.
    widest_ = static_cast<float>(std::min(widest, 2.0 * std::hypot(model.width, model.height)));
}

void LineSearch::straighten(const std::vector<EdgePoint>& points) {
    unsorted_.clear();
    for (const EdgePoint& p : points) {
        const int i = static_cast<int>(p.x) / grid;
        const int j = static_cast<int>(p.y) / grid;
        const Eigen::Vector2f& top_left = straight_[static_cast<std::size_t>(j * grid_across_ + i)];
        const Eigen::Vector2f& top_right = straight_[static_cast<std::size_t>(j * grid_across_ + i + 1)];
        const Eigen::Vector2f& low_left = straight_[static_cast<std::size_t>((j + 1) * grid_across_ + i)];
        const Eigen::Vector2f& low_right = straight_[static_cast<std::size_t>((j + 1) * grid_across_ + i + 1)];
        const float u = p.x / grid - static_cast<float>(i);
        const float v = p.y / grid - static_cast<float>(j);
        const Eigen::Vector2f across = (1 - v) * (top_right - top_left) + v * (low_right - low_left);
        const Eigen::Vector2f down = (1 - u) * (low_left - top_left) + u * (low_right - top_right);
        const Eigen::Vector2f place = (1 - v) * top_left + v * low_left + u * across;
        if (!(place.squaredNorm() < widest_ * widest_)) continue;
        const Eigen::Vector2f tangent = -p.ny * across + p.nx * down;
        const Eigen::Vector2f normal = Eigen::Vector2f(tangent.y(), -tangent.x()).normalized();
        const float angle = std::atan2(normal.y(), normal.x()) * static_cast<float>(angles / (2 * std::numbers::pi));
        unsorted_.push_back({place.x(), place.y(), normal.x(), normal.y(), p.strength, angle < 0 ? angle + angles : angle});
    }
    // Sorted by direction, so that a line looks only at points that run along it.
    sector_starts_.fill(0);
    const auto sector = [](const StraightPoint& p) {
        return std::min(static_cast<std::size_t>(p.angle * (sectors / static_cast<float>(angles))), sectors - 1);
    };
    for (const StraightPoint& p : unsorted_) ++sector_starts_[sector(p) + 1];
    for (std::size_t i = 1; i <= sectors; ++i) sector_starts_[i] += sector_starts_[i - 1];
    points_.resize(unsorted_.size());
    claimed_.assign(unsorted_.size(), 0);
    auto next = sector_starts_;
    for (const StraightPoint& p : unsorted_) points_[next[sector(p)]++] = p;
}

/// Calls `visit` for every point that runs along a line with this normal and belongs to no line yet.
template <class Visit>
void LineSearch::along(const Eigen::Vector2f& normal, const Visit& visit) const {
    const float aligned = static_cast<float>(std::cos(settings_.point_angle * std::numbers::pi / 180));
    const double middle = static_cast<double>(std::atan2(normal.y(), normal.x())) * sectors / (2 * std::numbers::pi);
    const double reach = settings_.point_angle * sectors / 360.0;
    for (int s = static_cast<int>(std::floor(middle - reach)); s <= static_cast<int>(std::floor(middle + reach)); ++s) {
        const auto index = static_cast<std::size_t>((s + 2 * static_cast<int>(sectors)) % static_cast<int>(sectors));
        for (std::size_t i = sector_starts_[index]; i < sector_starts_[index + 1]; ++i) {
            const StraightPoint& p = points_[i];
            if (!claimed_[i] && normal.x() * p.nx + normal.y() * p.ny >= aligned) visit(p, i);
        }
    }
}

void LineSearch::vote(int reduction) {
    distance_cell_ = static_cast<float>(reduction);
    distances_ = 2 * static_cast<int>(std::ceil(widest_ / distance_cell_)) + 4;
    votes_.assign(static_cast<std::size_t>(angles) * static_cast<std::size_t>(distances_), 0);
    const float inverse = 1 / distance_cell_;
    const float zero = 0.5f * static_cast<float>(distances_);
    for (const StraightPoint& p : points_) {
        const int middle = static_cast<int>(p.angle + 0.5f);
        // A gradient over its noise of 8 tells its direction within a few degrees.
        const int spread =
            static_cast<int>(std::lround(std::clamp(1.0 + 3.0 * settings_.angle_spread / static_cast<double>(p.strength), 2.0, 3 * settings_.angle_spread)));
        const float weight = std::min(p.strength, 8.0f) * 0.125f + 0.5f;
        for (int a = middle - spread; a <= middle + spread; ++a) {
            const int index = (a + 2 * angles) % angles;
            const Eigen::Vector2f& d = directions[static_cast<std::size_t>(index)];
            const float at = (d.x() * p.x + d.y() * p.y) * inverse + zero;
            const int cell = static_cast<int>(at);
            const float part = at - static_cast<float>(cell);
            float* votes = votes_.data() + static_cast<std::ptrdiff_t>(index) * distances_ + cell;
            votes[0] += weight * (1 - part);
            votes[1] += weight * part;
        }
    }
}

void LineSearch::find_peaks() {
    peaks_.clear();
    const float least = static_cast<float>(settings_.least_points) * 0.75f;
    for (int a = 0; a < angles; ++a) {
        const float* row = votes_.data() + static_cast<std::ptrdiff_t>(a) * distances_;
        const float* before = votes_.data() + static_cast<std::ptrdiff_t>((a + angles - 1) % angles) * distances_;
        const float* after = votes_.data() + static_cast<std::ptrdiff_t>((a + 1) % angles) * distances_;
        for (int d = 1; d + 1 < distances_; ++d) {
            const float v = row[d];
            if (v < least || v < row[d - 1] || v <= row[d + 1]) continue;
            if (v < before[d] || v < before[d - 1] || v < before[d + 1] || v <= after[d] || v <= after[d - 1] || v <= after[d + 1]) continue;
            peaks_.push_back({a, d, v});
        }
    }
    const std::size_t keep = std::min(peaks_.size(), 2 * settings_.most_lines);
    std::partial_sort(peaks_.begin(), peaks_.begin() + static_cast<std::ptrdiff_t>(keep), peaks_.end(),
                      [](const Peak& a, const Peak& b) { return a.votes > b.votes; });
    peaks_.resize(keep);
}

/// Total least squares through the points of a peak, twice, and where along the line they are. The line claims its points: slightly turned
/// copies of a strong line would be as strong otherwise.
bool LineSearch::fit(const Peak& peak, int reduction, SceneLine& line) {
    Eigen::Vector2f normal = directions[static_cast<std::size_t>(peak.angle)];
    float distance = (static_cast<float>(peak.distance) - 0.5f * static_cast<float>(distances_)) * distance_cell_;
    for (int round = 0; round < 2; ++round) {
        const float near = static_cast<float>((round == 0 ? 1.6 : 1.0) * settings_.point_distance * reduction);
        double w = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
        along(normal, [&](const StraightPoint& p, std::size_t) {
            if (std::abs(normal.x() * p.x + normal.y() * p.y - distance) > near) return;
            const double weight = static_cast<double>(std::min(p.strength, 10.0f));
            const double x = static_cast<double>(p.x);
            const double y = static_cast<double>(p.y);
            w += weight;
            sx += weight * x;
            sy += weight * y;
            sxx += weight * x * x;
            sxy += weight * x * y;
            syy += weight * y * y;
        });
        if (!(w > 0)) return false;
        const double mx = sx / w;
        const double my = sy / w;
        const double angle = 0.5 * std::atan2(2 * (sxy / w - mx * my), (sxx / w - mx * mx) - (syy / w - my * my));  // of the line itself
        Eigen::Vector2f turned(static_cast<float>(-std::sin(angle)), static_cast<float>(std::cos(angle)));
        if (turned.dot(normal) < 0) turned = -turned;
        if (turned.dot(normal) < 0.9f) return false;
        normal = turned;
        distance = normal.x() * static_cast<float>(mx) + normal.y() * static_cast<float>(my);
    }
    std::array<std::int16_t, SceneLine::cells> count{};
    const float cell = 4 * static_cast<float>(reduction);  // px
    const float first = -0.5f * SceneLine::cells * cell;
    const float near = static_cast<float>(settings_.point_distance * reduction);
    line.points = 0;
    taken_.clear();
    along(normal, [&](const StraightPoint& p, std::size_t i) {
        if (std::abs(normal.x() * p.x + normal.y() * p.y - distance) > near) return;
        taken_.push_back(i);
        const float at = (-normal.y() * p.x + normal.x() * p.y - first) / cell;
        const int index = static_cast<int>(at);
        if (at < 0 || index >= SceneLine::cells) return;
        ++count[static_cast<std::size_t>(index)];
        ++line.points;
    });
    line.normal = normal.cast<double>().normalized();
    line.distance = static_cast<double>(distance) / focal_;
    line.cell = static_cast<double>(cell) / focal_;
    line.first = static_cast<double>(first) / focal_;
    for (std::size_t i = 0; i < count.size(); ++i) line.filled[i + 1] = static_cast<std::int16_t>(line.filled[i] + (count[i] > 0));
    if (line.points < least_) return false;
    const auto is_filled = [](int n) { return n > 0; };
    line.first_filled = static_cast<int>(std::find_if(count.begin(), count.end(), is_filled) - count.begin());
    line.last_filled = static_cast<int>(count.rend() - std::find_if(count.rbegin(), count.rend(), is_filled)) - 1;
    line.density = line.points * reduction / static_cast<double>(cell * static_cast<float>(line.last_filled + 1 - line.first_filled));
    for (const std::size_t i : taken_) claimed_[i] = 1;
    return true;
}

void LineSearch::find(const std::vector<EdgePoint>& points, int reduction, std::vector<SceneLine>& lines) {
    lines.clear();
    straighten(points);
    vote(reduction);
    find_peaks();
    // So many points lie along any line by chance; a line has five standard deviations more.
    const double chance = static_cast<double>(points_.size()) * 2 * settings_.point_distance * reduction * 0.7 * std::hypot(model_.width, model_.height) /
                          (static_cast<double>(model_.width) * model_.height) * settings_.point_angle / 180;
    least_ = std::max(settings_.least_points, chance + 5 * std::sqrt(chance));
    for (const Peak& peak : peaks_) {
        SceneLine line;
        if (!fit(peak, reduction, line)) continue;
        lines.push_back(line);
        if (lines.size() == settings_.most_lines) break;
    }
    std::stable_sort(lines.begin(), lines.end(), [](const SceneLine& a, const SceneLine& b) { return a.points > b.points; });
}

}  // namespace roomfix
