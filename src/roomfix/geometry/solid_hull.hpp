// Convex hulls of points in space.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace roomfix {

/// Volume of the hull of some hundred points at most (m^3); 0 where they lie in a plane. Takes points in turn and replaces
/// the faces that each sees (the incremental algorithm; de Berg et al., Computational Geometry, ch. 11).
double hull_volume(std::span<const Eigen::Vector3d> points);

/// For each of the 162 or 642 directions of icosphere(2) or (3), the farthest of the points. Points may be added bit by bit.
class Supports {
public:
    enum class Directions { few, many };
    explicit Supports(Directions directions);

    void add(const Eigen::Vector3d& point);
    void add(const Supports& other);
    bool empty() const { return reach_[0] == none; }

    /// Volume of the hull of the farthest points (m^3).
    double volume() const;

    /// The fewest points found, at most `most`, whose hull falls short of all others by `tolerance` (m) at most: the point that
    /// falls shortest is added until none does.
    std::vector<Eigen::Vector3d> corners(double tolerance, std::size_t most) const;

private:
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3>;
    static constexpr double none = -1e300;
    static Rows sphere_directions(int level);

    const Rows* directions_;
    Eigen::VectorXd reach_;                // m along each direction
    std::vector<Eigen::Vector3d> points_;  // that reach so far
    Eigen::VectorXd reach_of_point_;       // working memory
};

}  // namespace roomfix
