#include "roomfix/evaluate/consistency.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"

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

NeesBand mean_nees_band(const std::vector<StatedError>& errors) {
    constexpr int experiments = 10000;
    struct Whitened {
        Eigen::MatrixXd own, shared;
        std::size_t group;
    };
    std::vector<Whitened> all;
    Eigen::Index most_shared = 0;
    std::size_t groups = 0;
    for (const StatedError& e : errors) {
        const Eigen::LLT<Eigen::MatrixXd> whole(e.own + e.shared * e.shared.transpose());
        const Eigen::MatrixXd own = Eigen::LLT<Eigen::MatrixXd>(e.own).matrixL();
        const auto group = static_cast<std::size_t>(e.group);
        all.push_back({whole.matrixL().solve(own), whole.matrixL().solve(e.shared), group});
        most_shared = std::max(most_shared, e.shared.cols());
        groups = std::max(groups, group + 1);
    }
    if (all.empty()) return {};
    Random random(1);
    const auto draw = [&](Eigen::Index count) {
        Eigen::VectorXd drawn(count);
        for (Eigen::Index i = 0; i < count; ++i) drawn[i] = random.normal();
        return drawn;
    };
    std::vector<double> means;
    std::vector<Eigen::VectorXd> of_group(groups);
    for (int k = 0; k < experiments; ++k) {
        for (Eigen::VectorXd& shared : of_group) shared = draw(most_shared);
        double sum = 0;
        for (const Whitened& e : all) sum += (e.own * draw(e.own.cols()) + e.shared * of_group[e.group].head(e.shared.cols())).squaredNorm();
        means.push_back(sum / static_cast<double>(all.size()));
    }
    std::sort(means.begin(), means.end());
    return {means[experiments / 40], means[experiments - 1 - experiments / 40]};
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
