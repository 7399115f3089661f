#include "roomfix/calibrate/straightness.hpp"

#include <algorithm>
#include <cstddef>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

/// Legendre polynomials by columns, at the points' places along the edge.
Eigen::MatrixXd legendre(const LongEdge& edge, Eigen::Index orders) {
    const auto count = static_cast<Eigen::Index>(edge.points.size());
    Eigen::VectorXd along = Eigen::VectorXd::Zero(count);
    for (Eigen::Index i = 1; i < count; ++i) {
        along[i] = along[i - 1] + (edge.points[static_cast<std::size_t>(i)] - edge.points[static_cast<std::size_t>(i) - 1]).norm();
    }
    along = 2 * along.array() / along[count - 1] - 1;
    Eigen::MatrixXd basis(count, orders);
    basis.col(0).setOnes();
    basis.col(1) = along;
    for (Eigen::Index n = 1; n + 1 < orders; ++n) {
        const auto order = static_cast<double>(n);
        basis.col(n + 1) = ((2 * order + 1) * along.cwiseProduct(basis.col(n)) - order * basis.col(n - 1)) / (order + 1);
    }
    return basis;
}

}  // namespace

Eigen::VectorXd crookedness(const CameraModel& model, const LongEdge& edge) {
    constexpr double no_ray = 3;  // px
    const auto count = static_cast<Eigen::Index>(edge.points.size());
    Eigen::Matrix<double, 2, Eigen::Dynamic> rays(2, count);
    std::vector<Eigen::Matrix2d> by_pixel(edge.points.size());
    std::vector<Eigen::Index> known;
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto ray = unproject(model, edge.points[static_cast<std::size_t>(i)], &by_pixel[static_cast<std::size_t>(i)]);
        if (!ray) continue;
        rays.col(i) = *ray;
        known.push_back(i);
    }
    Eigen::VectorXd off = Eigen::VectorXd::Constant(count, no_ray);
    if (known.size() < 3) return off;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const Eigen::Index i : known) middle += rays.col(i) / static_cast<double>(known.size());
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const Eigen::Index i : known) spread += (rays.col(i) - middle) * (rays.col(i) - middle).transpose();
    Eigen::RowVector2d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvectors().col(0).transpose();
    if (normal.x() + 1e-3 * normal.y() < 0) normal = -normal;  // an eigenvector's sign is arbitrary; derivatives need the same one
    for (const Eigen::Index i : known) off[i] = normal.dot(rays.col(i) - middle) / (normal * by_pixel[static_cast<std::size_t>(i)]).norm();
    return off;
}

EdgeShape::EdgeShape(const LongEdge& edge) {
    constexpr Eigen::Index most = 10, points_per_order = 4;
    const auto count = static_cast<Eigen::Index>(edge.points.size());
    basis_ = legendre(edge, std::clamp<Eigen::Index>(count / points_per_order, bow + bends, most));
    const Eigen::MatrixXd inverse = (basis_.transpose() * basis_).inverse();
    from_points_ = inverse * basis_.transpose();
    variance_ = inverse.diagonal();
}

Eigen::MatrixXd EdgeShape::weighed(const Eigen::MatrixXd& off, const EdgeNoise& noise) const {
    const auto bent = basis_.middleCols(bow, bends);
    Eigen::MatrixXd known = noise.bend * (bent.transpose() * bent);
    known.diagonal().array() += noise.point;
    return (off - bent * known.lu().solve(noise.bend * (bent.transpose() * off))) / noise.point;
}

}  // namespace roomfix
