#include <fuse_flow/impl/calibration/dense_algebra.hpp>

#include <gtest/gtest.h>

namespace {

using namespace fuse_flow::host;

/** \brief Positive definite, its largest diagonal element last, so that factors are permuted. */
Eigen::MatrixXd pivoted() {
  Eigen::MatrixXd A(3, 3);
  A << 2, 1, 0, 1, 3, -1, 0, -1, 40;
  return A;
}

TEST(DenseAlgebra, WhiteningMakesTheMatrixTheIdentity) {
  const Eigen::MatrixXd A = pivoted(), W = CholeskyFactors(A).whitening();
  EXPECT_TRUE(transposedProduct(W, product(A, W)).isIdentity(1e-12)) << W;
}

TEST(DenseAlgebra, SolvesColumnByColumn) {
  const Eigen::MatrixXd A = pivoted(), X = Eigen::MatrixXd::Random(3, 2);
  EXPECT_TRUE(CholeskyFactors(A).solveColumns(product(A, X)).isApprox(X, 1e-12));
  // Of a diagonal matrix by hand: 1/4 + 4/16 + 9/9.
  const Eigen::MatrixXd S = Eigen::Vector3d(4, 16, 9).asDiagonal();
  EXPECT_NEAR(squaredMahalanobis(Eigen::Vector3d(1, 2, 3), CholeskyFactors(S)), 1.5, 1e-12);
}

TEST(DenseAlgebra, EigenvaluesRiseAndVectorsAreTheirs) {
  Eigen::MatrixXd A(2, 2);
  A << 2, 1, 1, 2;  // 1 along (1, −1), 3 along (1, 1)
  const SymmetricEigen eigen(A);
  EXPECT_TRUE(eigen.values.isApprox(Eigen::Vector2d(1, 3), 1e-12));
  EXPECT_NEAR(std::fabs(eigen.vectors(0, 1) + eigen.vectors(1, 1)), std::sqrt(2.0), 1e-12);
  EXPECT_EQ(SymmetricEigen(Eigen::MatrixXd(0, 0)).values.size(), 0);
}

TEST(DenseAlgebra, ABasisIsOrthonormalAndSpansTheSame) {
  Eigen::MatrixXd a(3, 2);  // nearly parallel, of very different length
  a << 1e6, 1, 1e6, 1 + 1e-7, 0, 0;
  const Eigen::MatrixXd Q = orthonormalBasis(a);
  EXPECT_TRUE(transposedProduct(Q, Q).isIdentity(1e-12)) << Q;
  EXPECT_TRUE(Q.row(2).isZero(1e-12)) << "both lie in the plane of the first two axes";
  EXPECT_TRUE(product(Q, transposedProduct(Q, a)).isApprox(a, 1e-12));
}

}  // namespace
