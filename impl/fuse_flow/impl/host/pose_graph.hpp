#pragma once

#include <fuse_flow/math/alignment.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <vector>

namespace fuse_flow {
namespace host {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

inline Matrix6d symmetric6(const double (&upper)[kTriangle6]) {
  Matrix6d A;
  int k = 0;
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column) A(row, column) = A(column, row) = upper[k++];
  return A;
}

/** \brief What noise σ_n of the normals makes of the same correspondences, were there nothing to tell: σ_n² Σ w (E − a aᵀ), E the
 *  information of all three directions at a point. */
inline Matrix6d spuriousInformation(const AlignmentSums& sums, double normal_noise) {
  const Eigen::Vector3d x(sums.wx);
  Eigen::Matrix3d xx;
  xx << sums.wxx[0], sums.wxx[1], sums.wxx[2], sums.wxx[1], sums.wxx[3], sums.wxx[4], sums.wxx[2], sums.wxx[4],
      sums.wxx[5];
  Eigen::Matrix3d hat;
  hat << 0, -x.z(), x.y(), x.z(), 0, -x.x(), -x.y(), x.x(), 0;
  Matrix6d E;
  E << sums.w * Eigen::Matrix3d::Identity(), -hat, hat, xx.trace() * Eigen::Matrix3d::Identity() - xx;
  return normal_noise * normal_noise * (E - symmetric6(sums.A));
}

/** \brief Gauss–Newton over the twists of all cameras, the first one held. What the data tell no better than noise would, stays.
 *
 *  With H the information of all correspondences and S what of it noise explains, the generalised eigenvalues of H v = λ S v say
 *  of each joint motion v how much more there is than noise; they depend neither on units nor on which camera is held, and
 *  long chains of cameras, whose information is small, keep it where a slide along a wall does not. */
class PoseGraph {
 public:
  explicit PoseGraph(std::size_t cameras)
      : size_(6 * (static_cast<Eigen::Index>(cameras) - 1)),
        H_(Eigen::MatrixXd::Zero(size_, size_)),
        S_(Eigen::MatrixXd::Zero(size_, size_)),
        C_(Eigen::MatrixXd::Zero(size_, size_)),
        g_(Eigen::VectorXd::Zero(size_)),
        g_color_(Eigen::VectorXd::Zero(size_)) {}

  /** \brief Correspondences between two cameras. */
  void addGeometry(std::size_t i, std::size_t j, const AlignmentSums& sums, double normal_noise) {
    addBlocks(H_, i, j, symmetric6(sums.A));
    addBlocks(S_, i, j, spuriousInformation(sums, normal_noise));
    addGradient(g_, i, j, Vector6d(sums.g));
  }
  void addColor(std::size_t i, std::size_t j, const AlignmentSums& sums) {
    addBlocks(C_, i, j, symmetric6(sums.A));
    addGradient(g_color_, i, j, Vector6d(sums.g));
  }

  /** \brief \param min_information λ under which a motion is left alone */
  void decompose(double min_information) {
    const double ridge =
        1e-9 * (1e-300 + S_.trace() + H_.trace()) / static_cast<double>(std::max<Eigen::Index>(1, size_));
    S_.diagonal().array() += ridge;
    const Eigen::LLT<Eigen::MatrixXd> cholesky(S_);
    const Eigen::MatrixXd left = cholesky.matrixL().solve(H_);
    const Eigen::MatrixXd M = cholesky.matrixL().solve(left.transpose());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (M + M.transpose()));
    information_ = eigen.eigenvalues();
    modes_ = cholesky.matrixU().solve(eigen.eigenvectors());  // ξ = L⁻ᵀ v
    free_ = 0;
    while (free_ < size_ && information_[free_] < min_information) ++free_;
    if (free_ > 0)
      free_motions_ = modes_.leftCols(free_).householderQr().householderQ() * Eigen::MatrixXd::Identity(size_, free_);
    else
      free_motions_.resize(size_, 0);
  }

  /** \brief How many joint motions the geometry does not tell. */
  Eigen::Index freeMotions() const { return free_; }
  /** \brief An orthonormal basis of one camera's part in the motions that neither geometry nor colour tells: unit twists. */
  std::vector<Vector6d> freeDirections(std::size_t camera) const {
    std::vector<Vector6d> directions;
    if (camera == 0 || free_motions_.cols() == 0) return directions;
    const Eigen::MatrixXd part = free_motions_.middleRows<6>(begin(camera));
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(part * part.transpose());
    for (Eigen::Index k = 5; k >= 0; --k)
      if (eigen.eigenvalues()[k] > kPart) directions.push_back(eigen.eigenvectors().col(k));
    return directions;
  }

  /** \brief The step that lowers the squared residuals of the geometry most, camera by camera; zero along free motions. */
  Eigen::VectorXd step() const {
    Eigen::VectorXd along = -modes_.transpose() * g_;
    for (Eigen::Index k = 0; k < size_; ++k) along[k] = k < free_ ? 0.0 : along[k] / information_[k];
    return modes_ * along;
  }

  /** \brief The same with colour, which joins in where geometry tells little and stands alone along free motions.
   *  \param enough information of geometry from which on colour is not asked: it is seldom registered as well as depth
   *  \param max_deviation what colour must tell a free motion to, in the unit of the twists */
  Eigen::VectorXd stepWithColor(double enough, double max_deviation) {
    Eigen::Index weak = free_;
    while (weak < size_ && information_[weak] < enough) ++weak;
    Eigen::VectorXd along = -modes_.transpose() * g_;
    along.head(free_).setZero();
    along.tail(size_ - weak).array() /= information_.tail(size_ - weak).array();
    if (weak > free_) {
      const Eigen::MatrixXd W = modes_.middleCols(free_, weak - free_);
      Eigen::MatrixXd both = W.transpose() * C_ * W;
      both.diagonal() += information_.segment(free_, weak - free_);
      along.segment(free_, weak - free_) =
          both.ldlt().solve(along.segment(free_, weak - free_) - W.transpose() * g_color_);
    }
    return modes_ * along + stepOfColor(max_deviation);
  }

  /** \brief Covariance of a camera's twist relative to camera 0, along what the data tell, for unit residual variance. */
  Matrix6d covariance(std::size_t camera) const {
    Matrix6d sum = Matrix6d::Zero();
    if (camera == 0) return sum;
    for (Eigen::Index k = free_; k < size_; ++k) {
      const Vector6d v = modes_.col(k).segment<6>(begin(camera));
      sum += v * v.transpose() / information_[k];
    }
    return sum;
  }

 private:
  static Eigen::Index begin(std::size_t camera) { return 6 * (static_cast<Eigen::Index>(camera) - 1); }

  Eigen::VectorXd stepOfColor(double max_deviation) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(size_);
    if (free_ == 0) return step;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(free_motions_.transpose() * C_ * free_motions_);
    const Eigen::MatrixXd motions = free_motions_ * eigen.eigenvectors();
    Eigen::Index untold = 0;
    for (Eigen::Index k = 0; k < free_; ++k) {
      if (eigen.eigenvalues()[k] * max_deviation * max_deviation > 1) {
        step -= motions.col(k) * (motions.col(k).dot(g_color_) / eigen.eigenvalues()[k]);
      } else {
        ++untold;  // in rising order: these come first
      }
    }
    free_motions_ = motions.leftCols(untold);
    return step;
  }

  static void addBlocks(Eigen::MatrixXd& M, std::size_t i, std::size_t j, const Matrix6d& A) {
    if (i > 0) M.block<6, 6>(begin(i), begin(i)) += A;
    if (j > 0) M.block<6, 6>(begin(j), begin(j)) += A;
    if (i == 0 || j == 0) return;
    M.block<6, 6>(begin(i), begin(j)) -= A;
    M.block<6, 6>(begin(j), begin(i)) -= A;
  }
  static void addGradient(Eigen::VectorXd& g, std::size_t i, std::size_t j, const Vector6d& a) {
    if (i > 0) g.segment<6>(begin(i)) += a;
    if (j > 0) g.segment<6>(begin(j)) -= a;
  }

  /** \brief A camera has a part in a motion if its twist is over this share of it, squared. */
  static constexpr double kPart = 1e-3;

  Eigen::Index size_;
  Eigen::MatrixXd H_, S_, C_;
  Eigen::VectorXd g_, g_color_;
  Eigen::VectorXd information_;
  Eigen::MatrixXd modes_;
  Eigen::Index free_{0};
  Eigen::MatrixXd free_motions_;  ///< orthonormal columns
};

}  // namespace host
}  // namespace fuse_flow
