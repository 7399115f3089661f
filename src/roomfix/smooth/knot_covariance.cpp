#include "roomfix/smooth/knot_covariance.hpp"

#include <algorithm>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

/// J^T J as blocks: a diagonal of slices, their couplings, and the border.
struct Information {
    std::vector<Eigen::Index> starts;      // the first column of each slice, and the first common one
    std::vector<Eigen::MatrixXd> own;      // of each slice
    std::vector<Eigen::MatrixXd> to_next;  // of each slice but the last: rows its own, columns the next one's
    Eigen::MatrixXd border;                // all slices' rows, common columns
    Eigen::MatrixXd common;
};

Information information_of(const Eigen::SparseMatrix<double, Eigen::RowMajor>& jacobian, const std::vector<Eigen::Index>& slices) {
    Information all;
    all.starts.push_back(0);
    std::vector<std::size_t> slice_of;  // of each column
    for (std::size_t s = 0; s < slices.size(); ++s) {
        all.starts.push_back(all.starts.back() + slices[s]);
        slice_of.insert(slice_of.end(), static_cast<std::size_t>(slices[s]), s);
        all.own.emplace_back(Eigen::MatrixXd::Zero(slices[s], slices[s]));
        if (s + 1 < slices.size()) all.to_next.emplace_back(Eigen::MatrixXd::Zero(slices[s], slices[s + 1]));
    }
    const Eigen::Index n = all.starts.back();
    const Eigen::Index m = jacobian.cols() - n;
    all.border.setZero(n, m);
    all.common.setZero(m, m);
    using Entry = Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator;
    for (Eigen::Index row = 0; row < jacobian.outerSize(); ++row) {
        for (Entry a(jacobian, row); a; ++a) {
            for (Entry b(jacobian, row); b; ++b) {
                const double product = a.value() * b.value();
                if (a.col() >= n) {
                    if (b.col() >= n) all.common(a.col() - n, b.col() - n) += product;
                    continue;
                }
                if (b.col() >= n) {
                    all.border(a.col(), b.col() - n) += product;
                    continue;
                }
                const std::size_t at = slice_of[static_cast<std::size_t>(a.col())], other = slice_of[static_cast<std::size_t>(b.col())];
                const Eigen::Index r = a.col() - all.starts[at], c = b.col() - all.starts[other];
                if (at == other) {
                    all.own[at](r, c) += product;
                } else if (at + 1 == other) {
                    all.to_next[at](r, c) += product;
                }
            }
        }
    }
    return all;
}

/// The two sweeps.
class ChainInverse {
public:
    explicit ChainInverse(const Information& info) : starts_(info.starts), pivots_(info.own.size()), follow_(info.to_next.size()), solved_(info.border) {
        const std::size_t slices = info.own.size();
        // Forwards: each slice's information, those before it taken out.
        for (std::size_t s = 0; s < slices; ++s) {
            Eigen::MatrixXd own = info.own[s];
            if (s > 0) {
                own.noalias() -= info.to_next[s - 1].transpose() * follow_[s - 1];
                if (solved_.cols() > 0) rows(s).noalias() -= follow_[s - 1].transpose() * rows(s - 1);
            }
            pivots_[s].compute(own);
            if (pivots_[s].info() != Eigen::Success) return;
            if (s + 1 < slices) follow_[s] = pivots_[s].solve(info.to_next[s]);
        }
        // Backwards: covariances without the border's part, and T^-1 B.
        own_.resize(slices);
        with_next_.resize(slices - 1);
        for (std::size_t s = slices; s-- > 0;) {
            own_[s] = pivots_[s].solve(Eigen::MatrixXd::Identity(info.own[s].rows(), info.own[s].rows()));
            if (solved_.cols() > 0) {
                rows(s) = pivots_[s].solve(rows(s)).eval();
                if (s + 1 < slices) rows(s).noalias() -= follow_[s] * rows(s + 1);
            }
            if (s + 1 == slices) continue;
            with_next_[s] = -follow_[s] * own_[s + 1];
            own_[s].noalias() -= with_next_[s] * follow_[s].transpose();
        }
    }

    bool exists() const { return !own_.empty(); }
    /// T^-1 B
    const Eigen::MatrixXd& border() const { return solved_; }

    /// Of the six columns from `row` with those from `column`, not before them and at most in the next slice.
    Matrix6d between(Eigen::Index row, Eigen::Index column) const {
        const std::size_t a = slice_of(row), b = slice_of(column);
        return (a == b ? own_[a] : with_next_[a]).block<6, 6>(row - starts_[a], column - starts_[b]);
    }

private:
    Eigen::Block<Eigen::MatrixXd> rows(std::size_t slice) { return solved_.block(starts_[slice], 0, starts_[slice + 1] - starts_[slice], solved_.cols()); }
    std::size_t slice_of(Eigen::Index column) const {
        return static_cast<std::size_t>(std::upper_bound(starts_.begin(), starts_.end(), column) - starts_.begin()) - 1;
    }

    std::vector<Eigen::Index> starts_;
    std::vector<Eigen::LLT<Eigen::MatrixXd>> pivots_;
    std::vector<Eigen::MatrixXd> follow_;  // inverse pivot times coupling
    Eigen::MatrixXd solved_;
    std::vector<Eigen::MatrixXd> own_, with_next_;
};

}  // namespace

SmoothedCovariance smoothed_covariance(const Eigen::SparseMatrix<double, Eigen::RowMajor>& jacobian, const UnknownColumns& columns) {
    const Information info = information_of(jacobian, columns.slices);
    const ChainInverse chain(info);
    if (!chain.exists()) return {};
    SmoothedCovariance covariance;
    const bool bordered = info.common.rows() > 0;
    if (bordered) {
        const Eigen::LLT<Eigen::MatrixXd> schur(info.common - info.border.transpose() * chain.border());
        if (schur.info() != Eigen::Success) return {};
        covariance.common = schur.solve(Eigen::MatrixXd::Identity(info.common.rows(), info.common.cols()));
    }
    covariance.pairs.resize(columns.knots.size() - 1);
    Eigen::MatrixXd rows(12, info.common.cols());
    for (std::size_t k = 0; k + 1 < columns.knots.size(); ++k) {
        const Eigen::Index before = columns.knots[k], after = columns.knots[k + 1];
        const Matrix6d crossed = chain.between(before, after);
        PairCovariance& pair = covariance.pairs[k];
        pair << chain.between(before, before), crossed, crossed.transpose(), chain.between(after, after);
        if (!bordered) continue;
        rows << chain.border().middleRows<6>(before), chain.border().middleRows<6>(after);
        pair += rows * covariance.common * rows.transpose();
    }
    return covariance;
}

}  // namespace roomfix
