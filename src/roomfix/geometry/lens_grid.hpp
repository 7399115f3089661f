// Piecewise-linear correction of any lens, for those that no formula fits.
// Source: Chou and Tsai 1986, section 4.1: each triangle between points of a grid is mapped affinely.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "roomfix/base/result.hpp"

namespace roomfix {

/// A mesh of triangles from one plane to another; between its points it is affine in each triangle.
class TriangleMap {
public:
    /// Points of a grid with so many columns, row by row; both lists have the same length.
    TriangleMap(int columns, const std::vector<Eigen::Vector2d>& from, const std::vector<Eigen::Vector2d>& to);

    /// Nothing outside the mesh. `jacobian`, if asked for, is d(to)/d(from).
    std::optional<Eigen::Vector2d> at(const Eigen::Vector2d& point, Eigen::Matrix2d* jacobian = nullptr) const;

private:
    struct Triangle {
        Eigen::Vector2d corner;   // of `from`
        Eigen::Matrix2d inverse;  // point - corner to the shares of the two sides
        Eigen::Vector2d image;    // of the corner
        Eigen::Matrix2d affine;
    };
    static constexpr int bins = 48;  // in each direction

    Eigen::Vector2i bin_of(const Eigen::Vector2d& point) const;
    std::vector<Triangle> triangles_;
    std::vector<std::vector<int>> in_bin_;
    Eigen::Vector2d low_, size_;
};

/// Where points of a regular grid are seen in the picture, and where a lens without distortion would have shown them.
class LensGrid {
public:
    /// `seen` and `ideal`: px, row by row. An error if there are too few points, or the grid is folded over somewhere.
    static Result<LensGrid> create(int columns, std::vector<Eigen::Vector2d> seen, std::vector<Eigen::Vector2d> ideal);

    /// From a pixel of the picture to where a plain lens would have it; nothing outside the grid.
    std::optional<Eigen::Vector2d> corrected(const Eigen::Vector2d& pixel, Eigen::Matrix2d* jacobian = nullptr) const { return corrected_.at(pixel, jacobian); }
    /// The other way.
    std::optional<Eigen::Vector2d> distorted(const Eigen::Vector2d& ideal, Eigen::Matrix2d* jacobian = nullptr) const { return distorted_.at(ideal, jacobian); }

    int columns() const { return columns_; }
    const std::vector<Eigen::Vector2d>& seen() const { return seen_; }
    const std::vector<Eigen::Vector2d>& ideal() const { return ideal_; }

private:
    LensGrid(int columns, std::vector<Eigen::Vector2d> seen, std::vector<Eigen::Vector2d> ideal);

    int columns_;
    std::vector<Eigen::Vector2d> seen_, ideal_;
    TriangleMap corrected_, distorted_;
};

}  // namespace roomfix
