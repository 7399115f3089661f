// Eigen's decompositions. Those of the common sizes are compiled once, in cholesky.cpp, eigenvalues.cpp and lu_and_svd.cpp: compiled anew in each file that
// uses them, they took half of the build. Of larger matrices use the decomposition of Eigen::MatrixXd: one more fixed size costs half a minute of compiling.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#define ROOMFIX_MATRIX(rows, columns) Eigen::Matrix<double, rows, columns>

// `Kind` is LLT or LDLT. With the solution for one right hand side.
#define ROOMFIX_CHOLESKY(declared, Kind, n)                                                                                                \
    declared Eigen::Kind<ROOMFIX_MATRIX(n, n)>& Eigen::Kind<ROOMFIX_MATRIX(n, n)>::compute(const Eigen::EigenBase<ROOMFIX_MATRIX(n, n)>&); \
    declared void Eigen::Kind<ROOMFIX_MATRIX(n, n)>::_solve_impl_transposed<true>(const ROOMFIX_MATRIX(n, 1)&, ROOMFIX_MATRIX(n, 1)&) const;

#define ROOMFIX_CHOLESKYS(declared)                 \
    ROOMFIX_CHOLESKY(declared, LLT, 2)              \
    ROOMFIX_CHOLESKY(declared, LLT, 3)              \
    ROOMFIX_CHOLESKY(declared, LLT, 5)              \
    ROOMFIX_CHOLESKY(declared, LLT, 6)              \
    ROOMFIX_CHOLESKY(declared, LLT, 8)              \
    ROOMFIX_CHOLESKY(declared, LLT, Eigen::Dynamic) \
    ROOMFIX_CHOLESKY(declared, LDLT, 2)             \
    ROOMFIX_CHOLESKY(declared, LDLT, 3)             \
    ROOMFIX_CHOLESKY(declared, LDLT, 4)             \
    ROOMFIX_CHOLESKY(declared, LDLT, 5)             \
    ROOMFIX_CHOLESKY(declared, LDLT, 6)             \
    ROOMFIX_CHOLESKY(declared, LDLT, 12)            \
    ROOMFIX_CHOLESKY(declared, LDLT, Eigen::Dynamic)

#define ROOMFIX_EIGENVALUES(declared, n)                                                                                        \
    declared Eigen::SelfAdjointEigenSolver<ROOMFIX_MATRIX(n, n)>& Eigen::SelfAdjointEigenSolver<ROOMFIX_MATRIX(n, n)>::compute( \
        const Eigen::EigenBase<ROOMFIX_MATRIX(n, n)>&, int);

#define ROOMFIX_ALL_EIGENVALUES(declared) \
    ROOMFIX_EIGENVALUES(declared, 2)      \
    ROOMFIX_EIGENVALUES(declared, 3)      \
    ROOMFIX_EIGENVALUES(declared, Eigen::Dynamic)

// The decomposition by singular values is that of Quaternion::FromTwoVectors.
#define ROOMFIX_LU_AND_SVD(declared)                                                              \
    declared void Eigen::PartialPivLU<ROOMFIX_MATRIX(5, 5)>::compute();                           \
    declared void Eigen::PartialPivLU<ROOMFIX_MATRIX(6, 6)>::compute();                           \
    declared void Eigen::PartialPivLU<ROOMFIX_MATRIX(8, 8)>::compute();                           \
    declared void Eigen::PartialPivLU<ROOMFIX_MATRIX(Eigen::Dynamic, Eigen::Dynamic)>::compute(); \
    declared void Eigen::FullPivLU<ROOMFIX_MATRIX(3, 3)>::computeInPlace();                       \
    declared void Eigen::FullPivLU<ROOMFIX_MATRIX(4, 4)>::computeInPlace();                       \
    declared void Eigen::FullPivLU<ROOMFIX_MATRIX(8, 8)>::computeInPlace();                       \
    declared Eigen::JacobiSVD<ROOMFIX_MATRIX(2, 3)>& Eigen::JacobiSVD<ROOMFIX_MATRIX(2, 3)>::compute(const ROOMFIX_MATRIX(2, 3)&, unsigned);

ROOMFIX_CHOLESKYS(extern template)
ROOMFIX_ALL_EIGENVALUES(extern template)
ROOMFIX_LU_AND_SVD(extern template)

namespace roomfix {

/// Eigenvalues (ascending) and eigenvectors (columns) of a symmetric matrix of any size.
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> symmetric_eigen(const Eigen::MatrixXd& symmetric);

}  // namespace roomfix
