#pragma once

/** \file
 *  \brief Linear algebra of a few dozen unknowns. To Eigen every way to write an expression is another type, and compiling such
 *  types was half of the time to compile the classes that find poses; here each operation is compiled once. */

#include <fuse_flow/precompiled.h>

#include <Eigen/Cholesky>

namespace fuse_flow {
namespace host {

FUSE_FLOW_INLINE Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
FUSE_FLOW_INLINE Eigen::VectorXd product(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
/** \brief aᵀ b. */
FUSE_FLOW_INLINE Eigen::MatrixXd transposedProduct(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
FUSE_FLOW_INLINE Eigen::VectorXd transposedProduct(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
/** \brief Some of the columns. */
FUSE_FLOW_INLINE Eigen::MatrixXd columns(const Eigen::MatrixXd& a, Eigen::Index first, Eigen::Index count);

/** \brief A symmetric positive definite matrix, factored. */
class CholeskyFactors {
 public:
  FUSE_FLOW_INLINE explicit CholeskyFactors(const Eigen::MatrixXd& A);

  /** \brief Whether the matrix is what it should be, or has zeros among its eigenvalues; costs a fraction of these. */
  FUSE_FLOW_INLINE bool positive() const;
  FUSE_FLOW_INLINE Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  FUSE_FLOW_INLINE Eigen::MatrixXd solveColumns(const Eigen::MatrixXd& B) const;
  /** \brief W with Wᵀ A W the identity. */
  FUSE_FLOW_INLINE Eigen::MatrixXd whitening() const;

 private:
  Eigen::LDLT<Eigen::MatrixXd> ldlt_;
};

/** \brief xᵀ S⁻¹ x. */
FUSE_FLOW_INLINE double squaredMahalanobis(const Eigen::VectorXd& x, const CholeskyFactors& S);

/** \brief Eigenvalues, rising, and unit eigenvectors of a symmetric matrix. */
struct SymmetricEigen {
  FUSE_FLOW_INLINE explicit SymmetricEigen(const Eigen::MatrixXd& A);
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/** \brief An orthonormal basis of what independent columns span: Gram–Schmidt, twice, which is enough (Kahan; Parlett 1980). */
FUSE_FLOW_INLINE Eigen::MatrixXd orthonormalBasis(Eigen::MatrixXd a);

}  // namespace host
}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>

namespace fuse_flow {
namespace host {

FUSE_FLOW_INLINE Eigen::VectorXd product(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) { return a * b; }
FUSE_FLOW_INLINE Eigen::VectorXd transposedProduct(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.transpose() * b;
}
// Column by column, which is equally fast here. From nine cameras on, Eigen would compute a whole product on OpenMP's threads, regardless
// of the requested number of threads. While a fusion is running, these threads wait for each other a hundred times longer than they work.
FUSE_FLOW_INLINE Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd result(a.rows(), b.cols());
  for (Eigen::Index k = 0; k < b.cols(); ++k) result.col(k) = product(a, Eigen::VectorXd(b.col(k)));
  return result;
}
FUSE_FLOW_INLINE Eigen::MatrixXd transposedProduct(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd result(a.cols(), b.cols());
  for (Eigen::Index k = 0; k < b.cols(); ++k) result.col(k) = transposedProduct(a, Eigen::VectorXd(b.col(k)));
  return result;
}
FUSE_FLOW_INLINE Eigen::MatrixXd columns(const Eigen::MatrixXd& a, Eigen::Index first, Eigen::Index count) {
  return a.middleCols(first, count);
}

FUSE_FLOW_INLINE CholeskyFactors::CholeskyFactors(const Eigen::MatrixXd& A) : ldlt_(A) {}

FUSE_FLOW_INLINE bool CholeskyFactors::positive() const { return ldlt_.isPositive(); }

FUSE_FLOW_INLINE Eigen::VectorXd CholeskyFactors::solve(const Eigen::VectorXd& b) const { return ldlt_.solve(b); }

FUSE_FLOW_INLINE Eigen::MatrixXd CholeskyFactors::solveColumns(const Eigen::MatrixXd& B) const {
  Eigen::MatrixXd X(B.rows(), B.cols());
  for (Eigen::Index k = 0; k < B.cols(); ++k) X.col(k) = solve(B.col(k));
  return X;
}

FUSE_FLOW_INLINE Eigen::MatrixXd CholeskyFactors::whitening() const {
  const Eigen::VectorXd D = ldlt_.vectorD();
  const Eigen::Index n = D.size();
  Eigen::MatrixXd W(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
    x[k] = 1 / std::sqrt(std::max(D[k], std::numeric_limits<double>::min()));
    ldlt_.matrixU().solveInPlace(x);
    W.col(k) = ldlt_.transpositionsP().transpose() * x;
  }
  return W;
}

FUSE_FLOW_INLINE double squaredMahalanobis(const Eigen::VectorXd& x, const CholeskyFactors& S) {
  return x.dot(S.solve(x));
}

FUSE_FLOW_INLINE SymmetricEigen::SymmetricEigen(const Eigen::MatrixXd& A) {
  if (A.rows() == 0) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  values = solver.eigenvalues();
  vectors = solver.eigenvectors();
}

FUSE_FLOW_INLINE Eigen::MatrixXd orthonormalBasis(Eigen::MatrixXd a) {
  for (Eigen::Index k = 0; k < a.cols(); ++k) {
    Eigen::VectorXd x = a.col(k);
    for (int turn = 0; turn < 2; ++turn) {
      x /= x.norm();
      for (Eigen::Index j = 0; j < k; ++j) {
        const Eigen::VectorXd y = a.col(j);
        x -= y.dot(x) * y;
      }
    }
    a.col(k) = x / x.norm();
  }
  return a;
}

}  // namespace host
}  // namespace fuse_flow

#endif
