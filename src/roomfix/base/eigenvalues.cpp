#include "roomfix/base/decompositions.hpp"

ROOMFIX_ALL_EIGENVALUES(template)

namespace roomfix {

Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> symmetric_eigen(const Eigen::MatrixXd& symmetric) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric);
}

}  // namespace roomfix
