#include "roomfix/smooth/knot_covariance.hpp"

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

/// J^T J as blocks: a diagonal of knots, their couplings, and the border.
struct Information {
    std::vector<Matrix6d> own;      // of each knot
    std::vector<Matrix6d> to_next;  // of each knot but the last: rows its own, columns the next one's
    Eigen::MatrixXd border;         // all knots' rows, common columns
    Eigen::MatrixXd common;
};

Information information_of(const Eigen::SparseMatrix<double, Eigen::RowMajor>& jacobian, std::size_t knots) {
    const auto n = static_cast<Eigen::Index>(6 * knots);
    const Eigen::Index m = jacobian.cols() - n;
    Information all{std::vector<Matrix6d>(knots, Matrix6d::Zero()), std::vector<Matrix6d>(knots - 1, Matrix6d::Zero()), Eigen::MatrixXd::Zero(n, m),
                    Eigen::MatrixXd::Zero(m, m)};
    using Entry = Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator;
    for (Eigen::Index row = 0; row < jacobian.outerSize(); ++row) {
        for (Entry a(jacobian, row); a; ++a) {
            for (Entry b(jacobian, row); b; ++b) {
                const double product = a.value() * b.value();
                if (a.col() >= n) {
                    if (b.col() >= n) all.common(a.col() - n, b.col() - n) += product;
                } else if (b.col() >= n) {
                    all.border(a.col(), b.col() - n) += product;
                } else if (a.col() / 6 == b.col() / 6) {
                    all.own[static_cast<std::size_t>(a.col() / 6)](a.col() % 6, b.col() % 6) += product;
                } else if (a.col() / 6 < b.col() / 6) {
                    all.to_next[static_cast<std::size_t>(a.col() / 6)](a.col() % 6, b.col() % 6) += product;
                }
            }
        }
    }
    return all;
}

}  // namespace

SmoothedCovariance smoothed_covariance(const Eigen::SparseMatrix<double, Eigen::RowMajor>& jacobian, std::size_t knots) {
    const Information info = information_of(jacobian, knots);
    const bool bordered = info.common.rows() > 0;
    const auto block = [](std::size_t k) { return static_cast<Eigen::Index>(6 * k); };
    // Forwards: each knot's information, those before it taken out.
    std::vector<Eigen::LLT<Matrix6d>> pivot(knots);
    std::vector<Matrix6d> follow(knots - 1);  // inverse pivot times coupling
    Eigen::MatrixXd solved = info.border;     // becomes T^-1 B
    for (std::size_t k = 0; k < knots; ++k) {
        Matrix6d own = info.own[k];
        if (k > 0) {
            own -= info.to_next[k - 1].transpose() * follow[k - 1];
            if (bordered) solved.middleRows<6>(block(k)) -= follow[k - 1].transpose() * solved.middleRows<6>(block(k - 1));
        }
        pivot[k].compute(own);
        if (pivot[k].info() != Eigen::Success) return {};
        if (k + 1 < knots) follow[k] = pivot[k].solve(info.to_next[k]);
    }
    // Backwards: covariances without the border's part, and T^-1 B.
    std::vector<Matrix6d> own(knots), with_next(knots - 1);
    for (std::size_t k = knots; k-- > 0;) {
        own[k] = pivot[k].solve(Matrix6d::Identity());
        if (bordered) {
            auto rows = solved.middleRows<6>(block(k));
            rows = pivot[k].solve(rows).eval();
            if (k + 1 < knots) rows -= follow[k] * solved.middleRows<6>(block(k + 1));
        }
        if (k + 1 == knots) continue;
        with_next[k] = -follow[k] * own[k + 1];
        own[k] += follow[k] * own[k + 1] * follow[k].transpose();
    }
    SmoothedCovariance covariance;
    if (bordered) {
        const Eigen::LLT<Eigen::MatrixXd> schur(info.common - info.border.transpose() * solved);
        if (schur.info() != Eigen::Success) return {};
        covariance.common = schur.solve(Eigen::MatrixXd::Identity(info.common.rows(), info.common.cols()));
    }
    covariance.pairs.resize(knots - 1);
    for (std::size_t k = 0; k + 1 < knots; ++k) {
        covariance.pairs[k] << own[k], with_next[k], with_next[k].transpose(), own[k + 1];
        if (!bordered) continue;
        const auto rows = solved.middleRows<12>(block(k));
        covariance.pairs[k] += rows * covariance.common * rows.transpose();
    }
    return covariance;
}

}  // namespace roomfix
