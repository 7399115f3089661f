#include "roomfix/geometry/lens_grid.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

constexpr double edge = 1e-9;  // of a triangle: points on its sides belong to it

double area(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) { return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x(); }

/// Corners of the two triangles of each cell, as indices.
std::vector<std::array<std::size_t, 3>> triangles_of(int columns, std::size_t points) {
    std::vector<std::array<std::size_t, 3>> triangles;
    const auto across = static_cast<std::size_t>(columns);
    for (std::size_t i = 0; i + across + 1 < points; ++i) {
        if (i % across + 1 == across) continue;
        triangles.push_back({i, i + 1, i + across});
        triangles.push_back({i + across + 1, i + across, i + 1});
    }
    return triangles;
}

}  // namespace

TriangleMap::TriangleMap(int columns, const std::vector<Eigen::Vector2d>& from, const std::vector<Eigen::Vector2d>& to) : in_bin_(bins * bins) {
    low_ = Eigen::Vector2d(1e300, 1e300);
    Eigen::Vector2d high = -low_;
    for (const Eigen::Vector2d& p : from) {
        low_ = low_.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    size_ = (high - low_).cwiseMax(1e-9);
    for (const auto& [a, b, c] : triangles_of(columns, from.size())) {
        Eigen::Matrix2d sides, images;
        sides << from[b] - from[a], from[c] - from[a];
        images << to[b] - to[a], to[c] - to[a];
        const Eigen::Matrix2d inverse = sides.inverse();
        const int number = static_cast<int>(triangles_.size());
        triangles_.push_back({from[a], inverse, to[a], images * inverse});
        const Eigen::Vector2i first = bin_of(from[a].cwiseMin(from[b]).cwiseMin(from[c])), last = bin_of(from[a].cwiseMax(from[b]).cwiseMax(from[c]));
        for (int x = first.x(); x <= last.x(); ++x) {
            for (int y = first.y(); y <= last.y(); ++y) in_bin_[static_cast<std::size_t>(y * bins + x)].push_back(number);
        }
    }
}

Eigen::Vector2i TriangleMap::bin_of(const Eigen::Vector2d& point) const {
    const Eigen::Vector2d part = (point - low_).cwiseQuotient(size_) * bins;
    return {std::clamp(static_cast<int>(part.x()), 0, bins - 1), std::clamp(static_cast<int>(part.y()), 0, bins - 1)};
}

std::optional<Eigen::Vector2d> TriangleMap::at(const Eigen::Vector2d& point, Eigen::Matrix2d* jacobian) const {
    if (!((point - low_).minCoeff() >= -edge * size_.maxCoeff()) || !((low_ + size_ - point).minCoeff() >= -edge * size_.maxCoeff())) return std::nullopt;
    const Eigen::Vector2i bin = bin_of(point);
    for (const int number : in_bin_[static_cast<std::size_t>(bin.y() * bins + bin.x())]) {
        const Triangle& t = triangles_[static_cast<std::size_t>(number)];
        const Eigen::Vector2d shares = t.inverse * (point - t.corner);
        if (shares.minCoeff() < -edge || shares.sum() > 1 + edge) continue;
        if (jacobian != nullptr) *jacobian = t.affine;
        return Eigen::Vector2d(t.image + t.affine * (point - t.corner));
    }
    return std::nullopt;
}

LensGrid::LensGrid(int columns, std::vector<Eigen::Vector2d> seen, std::vector<Eigen::Vector2d> ideal)
    : columns_(columns), seen_(std::move(seen)), ideal_(std::move(ideal)), corrected_(columns, seen_, ideal_), distorted_(columns, ideal_, seen_) {}

Result<LensGrid> LensGrid::create(int columns, std::vector<Eigen::Vector2d> seen, std::vector<Eigen::Vector2d> ideal) {
    const auto across = static_cast<std::size_t>(std::max(columns, 0));
    if (across < 3 || seen.size() != ideal.size() || seen.size() % across != 0 || seen.size() / across < 3) {
        return Error{fmt::format("a grid needs 3 x 3 points or more, in full rows: {} points in rows of {} are none", seen.size(), columns)};
    }
    const double turn = area(seen[0], seen[1], seen[across]);
    for (const auto& [a, b, c] : triangles_of(columns, seen.size())) {
        const bool finite =
            seen[a].allFinite() && ideal[a].allFinite() && seen[b].allFinite() && ideal[b].allFinite() && seen[c].allFinite() && ideal[c].allFinite();
        if (!finite || !(area(seen[a], seen[b], seen[c]) * turn > 0) || !(area(ideal[a], ideal[b], ideal[c]) * turn > 0)) {
            return Error{
                fmt::format("the grid is folded over, mirrored, or half out of the picture near ({:.0f}, {:.0f}): check its points", seen[a].x(), seen[a].y())};
        }
    }
    return LensGrid(columns, std::move(seen), std::move(ideal));
}

}  // namespace roomfix
