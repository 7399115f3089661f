#include "roomfix/evaluate/consistency.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace roomfix {

Eigen::Vector3d pose_error(const Pose2& fix, const Pose2& truth, double symmetry) {
    const double yaw = symmetry > 0 ? std::remainder(fix.yaw - truth.yaw, symmetry) : 0;
    return {fix.x - truth.x, fix.y - truth.y, yaw};
}

double nees(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
    const Eigen::LLT<Eigen::Matrix3d> factor(covariance);
    if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    return error.dot(factor.solve(error));
}

Summary summarise(std::vector<double> values) {
    Summary s;
    s.count = values.size();
    if (values.empty()) return s;
    std::sort(values.begin(), values.end());
    for (const double v : values) {
        s.mean += v / static_cast<double>(values.size());
        s.rms += v * v / static_cast<double>(values.size());
    }
    s.rms = std::sqrt(s.rms);
    const auto at = [&](double part) { return values[std::min(static_cast<std::size_t>(part * static_cast<double>(values.size())), values.size() - 1)]; };
    s.median = at(0.5);
    s.p95 = at(0.95);
    s.max = values.back();
    return s;
}

}  // namespace roomfix
