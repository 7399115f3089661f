#include "roomfix/overhead/outline_agreement.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {

double nats_of_agreement(const SilhouetteObservation& a, const SilhouetteObservation& b) {
    constexpr double rough = 0.05;           // m: by how much the outline of a body that is not as described is off
    constexpr double least = -12, most = 2;  // two that agree may do so by chance
    const Eigen::Vector2d apart(a.pose.x - b.pose.x, a.pose.y - b.pose.y);
    const auto log_density = [&](const Eigen::Matrix2d& covariance) {
        return -0.5 * apart.dot(covariance.inverse() * apart) - 0.5 * std::log(covariance.determinant());
    };
    const Eigen::Matrix2d stated = (a.covariance + b.covariance).topLeftCorner<2, 2>();
    return std::clamp(log_density(stated) - log_density(stated + 2 * rough * rough * Eigen::Matrix2d::Identity()), least, most);
}

}  // namespace roomfix
