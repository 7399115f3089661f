#include "roomfix/geometry/solid_hull.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "roomfix/geometry/triangle_mesh.hpp"

namespace roomfix {
namespace {

struct Face {
    std::array<Eigen::Vector3d, 3> corners;
    std::array<int, 3> indices;
    Eigen::Vector3d normal;  // outwards, of length 1; zero where the face is none
};

/// Builds a hull from a first tetrahedron.
class GrowingHull {
public:
    explicit GrowingHull(std::span<const Eigen::Vector3d> points) : points_(points) {}

    /// False: the points lie in a plane.
    bool start() {
        Eigen::AlignedBox3d box;
        for (const Eigen::Vector3d& p : points_) box.extend(p);
        if (points_.size() < 4) return false;
        exact_ = 1e-7 * box.diagonal().norm();
        const Eigen::Vector3d& a = points_[0];
        const auto farthest = [&](const auto& distance) {
            std::size_t best = 0;
            for (std::size_t i = 1; i < points_.size(); ++i) {
                if (distance(points_[i]) > distance(points_[best])) best = i;
            }
            return best;
        };
        const std::size_t ib = farthest([&](const Eigen::Vector3d& p) { return (p - a).norm(); });
        const Eigen::Vector3d along = (points_[ib] - a).normalized();
        const std::size_t ic = farthest([&](const Eigen::Vector3d& p) { return (p - a).cross(along).norm(); });
        const Eigen::Vector3d normal = along.cross(points_[ic] - a).normalized();
        const std::size_t id = farthest([&](const Eigen::Vector3d& p) { return std::abs((p - a).dot(normal)); });
        if (!(std::abs((points_[id] - a).dot(normal)) > exact_)) return false;
        const bool above = (points_[id] - a).dot(normal) > 0;
        const int p = 0, q = static_cast<int>(above ? ic : ib), r = static_cast<int>(above ? ib : ic), top = static_cast<int>(id);
        for (const auto& f : {std::array{p, q, r}, std::array{q, p, top}, std::array{r, q, top}, std::array{p, r, top}}) add_face(f);
        return true;
    }

    void add(std::size_t index) {
        const Eigen::Vector3d& point = points_[index];
        const auto hidden = std::partition(faces_.begin(), faces_.end(), [&](const Face& f) { return (point - f.corners[0]).dot(f.normal) <= exact_; });
        if (hidden == faces_.end()) return;
        edges_.clear();
        for (auto face = hidden; face != faces_.end(); ++face) {
            for (std::size_t i = 0; i < 3; ++i) edges_.push_back({face->indices[i], face->indices[(i + 1) % 3]});
        }
        faces_.erase(hidden, faces_.end());
        for (const auto& [from, to] : edges_) {
            const bool inside = std::find(edges_.begin(), edges_.end(), std::array{to, from}) != edges_.end();
            if (!inside) add_face({from, to, static_cast<int>(index)});
        }
    }

    double volume() const {
        double six_volumes = 0;
        for (const Face& f : faces_) six_volumes += (f.corners[0] - points_[0]).dot((f.corners[1] - points_[0]).cross(f.corners[2] - points_[0]));
        return std::max(six_volumes / 6, 0.0);
    }

private:
    void add_face(const std::array<int, 3>& i) {
        const auto at = [&](std::size_t k) { return points_[static_cast<std::size_t>(i[k])]; };
        const Eigen::Vector3d area = (at(1) - at(0)).cross(at(2) - at(0));
        const double length = area.norm();
        const Eigen::Vector3d normal = length > exact_ * exact_ ? Eigen::Vector3d(area / length) : Eigen::Vector3d::Zero();
        faces_.push_back({{at(0), at(1), at(2)}, i, normal});
    }

    std::span<const Eigen::Vector3d> points_;
    double exact_ = 0;  // m: what is nearer to a face lies in it
    std::vector<Face> faces_;
    std::vector<std::array<int, 2>> edges_;
};

}  // namespace

double hull_volume(std::span<const Eigen::Vector3d> points) {
    GrowingHull hull(points);
    if (!hull.start()) return 0;
    for (std::size_t i = 0; i < points.size(); ++i) hull.add(i);
    return hull.volume();
}

Supports::Rows Supports::sphere_directions(int level) {
    const TriangleMesh ball = icosphere(level);
    Rows directions(static_cast<Eigen::Index>(ball.corners.size()), 3);
    for (Eigen::Index i = 0; i < directions.rows(); ++i) directions.row(i) = ball.corners[static_cast<std::size_t>(i)].transpose();
    return directions;
}

Supports::Supports(Directions directions) {
    static const Rows few = sphere_directions(2);
    static const Rows many = sphere_directions(3);
    directions_ = directions == Directions::few ? &few : &many;
    reach_.setConstant(directions_->rows(), none);
    points_.resize(static_cast<std::size_t>(directions_->rows()));
}

void Supports::add(const Eigen::Vector3d& point) {
    reach_of_point_.noalias() = *directions_ * point;
    if ((reach_of_point_ - reach_).maxCoeff() <= 0) return;  // most points
    for (Eigen::Index i = 0; i < reach_.size(); ++i) {
        if (reach_of_point_[i] <= reach_[i]) continue;
        reach_[i] = reach_of_point_[i];
        points_[static_cast<std::size_t>(i)] = point;
    }
}

void Supports::add(const Supports& other) {
    for (Eigen::Index i = 0; i < reach_.size(); ++i) {
        if (other.reach_[i] <= reach_[i]) continue;
        reach_[i] = other.reach_[i];
        points_[static_cast<std::size_t>(i)] = other.points_[static_cast<std::size_t>(i)];
    }
}

double Supports::volume() const {
    if (empty()) return 0;
    std::vector<Eigen::Vector3d> different;
    for (const Eigen::Vector3d& point : points_) {
        if (std::find(different.begin(), different.end(), point) == different.end()) different.push_back(point);
    }
    return hull_volume(different);
}

std::vector<Eigen::Vector3d> Supports::corners(double tolerance, std::size_t most) const {
    std::vector<Eigen::Vector3d> chosen;
    if (empty()) return chosen;
    Eigen::VectorXd short_by = Eigen::VectorXd::Constant(reach_.size(), -none);
    while (chosen.size() < most) {
        Eigen::Index worst = 0;
        if (short_by.maxCoeff(&worst) <= tolerance) break;
        chosen.push_back(points_[static_cast<std::size_t>(worst)]);
        short_by = short_by.cwiseMin(reach_ - *directions_ * chosen.back());
    }
    return chosen;
}

}  // namespace roomfix
