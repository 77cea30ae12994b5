#pragma once

#include <fuse_flow/impl/calibration/dense_algebra.hpp>
#include <fuse_flow/math/calibration/alignment.h>

#include <Eigen/Geometry>

#include <optional>
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

/** \brief The information of the grey levels of one pair of views about a motion a. A constant difference in brightness between the images
 *  is one more unknown of the least squares, which is eliminated (Schur complement). So shading that changes evenly gives no information: a
 *  small difference in brightness looks the same as a small motion. */
struct ColorInformation {
  Vector6d mean;  ///< gradient, Σ w a / Σ w
  Matrix6d all;   ///< Σ w (a − mean) (a − mean)ᵀ
  /** \brief The same of a and b, symmetric: what both images show. Their noise does not enter it, so it may be indefinite. */
  Matrix6d shared;
  Vector6d g;  ///< Σ w r (a − mean)

  explicit ColorInformation(const AlignmentSums& sums)
      : mean(Vector6d::Zero()), all(symmetric6(sums.A)), shared(SharedProduct(sums.shared)), g(sums.g) {
    if (sums.w > 0) {
      const Vector6d wa(sums.wa), wb(sums.wb);
      mean = wa / sums.w;
      all -= mean * wa.transpose();
      shared -= mean * wb.transpose();
      g -= sums.wr * mean;
    }
    shared = 0.5 * (shared + Matrix6d(shared.transpose()));
  }

 private:
  using SharedProduct = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>;
};

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

/** \brief What colour is for. */
struct ColorRole {
  /** \brief Information of geometry from which on it needs no colour. */
  double enough;
  /** \brief What colour must tell a motion to that geometry leaves open, in the unit of the twists. */
  double max_deviation;
};

/** \brief Gauss–Newton over the twists of all cameras; the first camera is fixed. Directions that the data determine no better than noise
 *  would are not changed.
 *
 *  H is the information of all correspondences, and S is the part of it that noise explains. The generalised eigenvalues of H v = λ S v
 *  give the ratio of information to noise for each joint motion v. They depend neither on units nor on the fixed camera. Long chains of
 *  cameras have little information, but it is more than noise; a slide along a wall has only noise. */
class PoseGraph {
 public:
  explicit PoseGraph(std::size_t cameras)
      : size_(6 * (static_cast<Eigen::Index>(cameras) - 1)),
        H_(Eigen::MatrixXd::Zero(size_, size_)),
        S_(Eigen::MatrixXd::Zero(size_, size_)),
        C_(Eigen::MatrixXd::Zero(size_, size_)),
        B_(Eigen::MatrixXd::Zero(size_, size_)),
        g_(Eigen::VectorXd::Zero(size_)),
        g_color_(Eigen::VectorXd::Zero(size_)) {}

  /** \brief Correspondences between two cameras. */
  void addGeometry(std::size_t i, std::size_t j, const AlignmentSums& sums, double normal_noise) {
    addBlocks(H_, i, j, symmetric6(sums.A));
    addBlocks(S_, i, j, spuriousInformation(sums, normal_noise));
    addGradient(g_, i, j, Vector6d(sums.g));
  }
  /** \brief \param trust factor of the weights */
  void addColor(std::size_t i, std::size_t j, const AlignmentSums& sums, double trust) {
    if (sums.count == 0) return;
    const ColorInformation color(sums);
    addBlocks(C_, i, j, trust * color.all);
    addBlocks(B_, i, j, trust * color.shared);
    addGradient(g_color_, i, j, trust * color.g);
  }

  /** \brief Which motions count as observable. Where geometry determines all, a factorisation shows it, and a step needs no modes: they wait
   *  until findModes() is called. \param min_information λ under which a motion is left alone, unless colour tells it
   *  \param color that joins in, if any */
  void decompose(double min_information, const std::optional<ColorRole>& color) {
    min_information_ = min_information;
    color_ = color;
    const double ridge =
        1e-9 * (1e-300 + S_.trace() + H_.trace()) / static_cast<double>(std::max<Eigen::Index>(1, size_));
    S_.diagonal().array() += ridge;
    free_ = 0;
    has_modes_ = plain_ = false;
    free_motions_.resize(size_, 0);
    all_observable_ = noneUnder(min_information);
    asks_color_ = color && !noneUnder(color->enough);
    if (!all_observable_) findModes();
  }

  /** \brief After decompose(): observable(), curvature() and all that follows from them. */
  void findModes() {
    if (has_modes_) return;
    has_modes_ = true;
    plain_ = all_observable_ && kNoiseShare * min_information_ >= 1;
    if (plain_) {  // λ of every mode is so large that sensitivity() takes exactly S off: the same in any basis
      geometry_ = size_;
      observable_ = Eigen::MatrixXd::Identity(size_, size_);
      curvature_ = color_ ? Eigen::MatrixXd(H_ + C_) : H_;
      return;
    }
    const Eigen::MatrixXd W = CholeskyFactors(S_).whitening();
    const SymmetricEigen information(transposedProduct(W, product(H_, W)));
    const Eigen::MatrixXd modes = product(W, information.vectors);
    free_ = 0;
    while (free_ < size_ && information.values[free_] < min_information_) ++free_;
    geometry_ = size_ - free_;
    observable_ = columns(modes, free_, geometry_);
    curvature_ = Eigen::MatrixXd::Zero(geometry_, geometry_);
    for (Eigen::Index k = 0; k < geometry_; ++k) curvature_(k, k) = information.values[free_ + k];
    free_modes_ = columns(modes, 0, free_);
    free_motions_ = orthonormalBasis(free_modes_);
    if (color_) joinColor(color_->max_deviation);
  }

  /** \brief After decompose() with colour: whether there is anything that geometry does not tell well. */
  bool asksColor() const { return asks_color_; }

  /** \brief Twists without their part in the motions that neither geometry nor colour tells. */
  Eigen::VectorXd withoutFree(const Eigen::VectorXd& twists) const {
    if (free_motions_.cols() == 0) return twists;
    const Eigen::VectorXd open = product(free_modes_, transposedProduct(free_modes_, product(S_, twists)));
    const Eigen::Index count = observable_.cols() - geometry_;
    if (count == 0) return twists - open;
    const Eigen::MatrixXd by_color = columns(observable_, geometry_, count);
    const CholeskyFactors information(curvature_.bottomRightCorner(count, count));
    return twists - open + product(by_color, information.solve(transposedProduct(by_color, product(C_, open))));
  }

  /** \brief How many joint motions the geometry does not tell. */
  Eigen::Index freeMotions() const { return free_; }
  /** \brief An orthonormal basis of one camera's part in the motions that neither geometry nor colour tells: unit twists. */
  std::vector<Vector6d> freeDirections(std::size_t camera) const {
    std::vector<Vector6d> directions;
    if (camera == 0 || free_motions_.cols() == 0) return directions;
    const Eigen::MatrixXd part = free_motions_.middleRows(begin(camera), 6).transpose();
    const SymmetricEigen eigen(transposedProduct(part, part));
    for (Eigen::Index k = 5; k >= 0; --k)
      if (eigen.values[k] > kPart) directions.emplace_back(eigen.vectors.col(k));
    return directions;
  }

  /** \brief The step that lowers the squared residuals most, camera by camera; zero along free motions. */
  Eigen::VectorXd step() const {
    if (all_observable_)
      return color_ ? CholeskyFactors(H_ + C_).solve(-(g_ + g_color_)) : CholeskyFactors(H_).solve(-g_);
    return product(observable_, CholeskyFactors(curvature_).solve(-scores(g_, g_color_)));
  }

  /** \brief The observable motions, columns; not of unit length. Any basis of them: modes, or where all is observable the twists. */
  const Eigen::MatrixXd& observable() const { return observable_; }
  /** \brief Of the squared residuals along observable(). */
  const Eigen::MatrixXd& curvature() const { return curvature_; }
  /** \brief The slopes along observable() that gradients of geometry and of colour add up to. */
  Eigen::VectorXd scores(const Eigen::VectorXd& geometry, const Eigen::VectorXd& color) const {
    if (plain_) return color_ ? Eigen::VectorXd(geometry + color) : geometry;
    Eigen::VectorXd result = transposedProduct(observable_, geometry);
    const Eigen::VectorXd of_color = transposedProduct(observable_, color);
    if (color_) result.head(geometry_) += of_color.head(geometry_);
    result.tail(result.size() - geometry_) = of_color.tail(result.size() - geometry_);
    return result;
  }
  /** \brief How fast scores() change along observable(), less what noise only makes believe: of the normals, and of grey levels. */
  Eigen::MatrixXd sensitivity() const {
    if (plain_) return lessUnshared(curvature_ - S_);
    Eigen::MatrixXd result = curvature_;  // along modes, in which S is the identity
    for (Eigen::Index k = 0; k < geometry_; ++k) result(k, k) -= std::min(1.0, kNoiseShare * result(k, k));
    result.bottomRightCorner(shared_.rows(), shared_.cols()) = shared_;
    return lessUnshared(result);
  }

  Eigen::Index size() const { return size_; }
  /** \brief Where a camera's twist begins among those of all; camera > 0. */
  static Eigen::Index begin(std::size_t camera) { return 6 * (static_cast<Eigen::Index>(camera) - 1); }
  static void addGradient(Eigen::VectorXd& g, std::size_t i, std::size_t j, const Vector6d& a) {
    if (i > 0) g.segment<6>(begin(i)) += a;
    if (j > 0) g.segment<6>(begin(j)) -= a;
  }

 private:
  static void addBlocks(Eigen::MatrixXd& M, std::size_t i, std::size_t j, const Matrix6d& A) {
    if (i > 0) M.block<6, 6>(begin(i), begin(i)) += A;
    if (j > 0) M.block<6, 6>(begin(j), begin(j)) += A;
    if (i == 0 || j == 0) return;
    M.block<6, 6>(begin(i), begin(j)) -= A;
    M.block<6, 6>(begin(j), begin(i)) -= A;
  }
  /** \brief Whether no λ is under a bound: H − bound · S has no negative eigenvalue, then. */
  bool noneUnder(double bound) const { return CholeskyFactors(H_ - bound * S_).positive(); }
  /** \brief Takes off what colour adds to geometry but only one image shows. Noise scatters about zero: where that would be more than
   *  colour adds, all of it is taken off. */
  Eigen::MatrixXd lessUnshared(const Eigen::MatrixXd& sensitivity) const {
    if (!color_) return sensitivity;
    const Eigen::MatrixXd by_geometry = columns(observable_, 0, geometry_);
    const Eigen::MatrixXd shared = transposedProduct(by_geometry, product(B_, by_geometry));
    const Eigen::MatrixXd alone =
        sensitivity.topLeftCorner(geometry_, geometry_) - transposedProduct(by_geometry, product(C_, by_geometry));
    Eigen::MatrixXd result = sensitivity;
    result.topLeftCorner(geometry_, geometry_) = alone + shared;
    if (CholeskyFactors(result).positive()) return result;
    const Eigen::MatrixXd W = CholeskyFactors(alone).whitening();
    const SymmetricEigen added(transposedProduct(W, product(shared, W)));
    Eigen::MatrixXd motions = product(alone, product(W, added.vectors));
    for (Eigen::Index k = 0; k < motions.cols(); ++k) motions.col(k) *= std::sqrt(std::max(0.0, added.values[k]));
    result.topLeftCorner(geometry_, geometry_) = alone + product(motions, Eigen::MatrixXd(motions.transpose()));
    return result;
  }
  /** \brief Colour joins in along what geometry tells, and stands alone along free motions that it tells: so well that the pose is known to
   *  max_deviation, and as something that both images show. What noise of one image seems to tell the other one does not. */
  void joinColor(double max_deviation) {
    curvature_ += transposedProduct(observable_, product(C_, observable_));
    if (free_ == 0) return;
    const SymmetricEigen information(transposedProduct(free_motions_, product(C_, free_motions_)));
    const Eigen::MatrixXd motions = product(free_motions_, information.vectors);
    Eigen::Index unobservable = 0;  // in rising order: these come first
    while (unobservable < free_ && information.values[unobservable] * max_deviation * max_deviation <= 1)
      ++unobservable;
    Eigen::MatrixXd seen = columns(motions, unobservable, free_ - unobservable);
    for (Eigen::Index k = 0; k < seen.cols(); ++k) seen.col(k) /= std::sqrt(information.values[unobservable + k]);
    const SymmetricEigen share(transposedProduct(seen, product(B_, seen)));
    seen = product(seen, share.vectors);  // along these C is the identity
    Eigen::Index unshared = 0;
    while (unshared < seen.cols() && share.values[unshared] < kShared) ++unshared;
    const Eigen::Index count = seen.cols() - unshared;
    const Eigen::MatrixXd both = columns(seen, unshared, count), basis = orthonormalBasis(both);
    // Slopes scatter by C and change by what is shared: motions are known as well as shared C⁻¹ shared says.
    Eigen::MatrixXd known = transposedProduct(both, product(C_, basis));
    for (Eigen::Index k = 0; k < count; ++k) known.row(k) *= std::min(1.0, share.values[unshared + k]);
    const SymmetricEigen certain(transposedProduct(known, known));
    Eigen::Index unsure = 0;
    while (unsure < count && certain.values[unsure] * max_deviation * max_deviation < 1) ++unsure;
    const Eigen::MatrixXd sorted = product(basis, certain.vectors);
    Eigen::MatrixXd open(size_, unobservable + unshared + unsure);
    open.leftCols(unobservable) = columns(motions, 0, unobservable);
    open.middleCols(unobservable, unshared) = columns(seen, 0, unshared);
    open.rightCols(unsure) = columns(sorted, 0, unsure);
    free_motions_ = orthonormalBasis(open);
    const Eigen::MatrixXd by_color = columns(sorted, unsure, count - unsure);
    Eigen::MatrixXd parts = transposedProduct(both, product(C_, by_color));
    const Eigen::MatrixXd all = transposedProduct(parts, parts);  // C along by_color
    for (Eigen::Index k = 0; k < count; ++k) parts.row(k) *= std::sqrt(std::min(1.0, share.values[unshared + k]));
    shared_ = transposedProduct(parts, parts);
    const Eigen::Index observed = geometry_ + by_color.cols();
    observable_.conservativeResize(size_, observed);
    observable_.rightCols(by_color.cols()) = by_color;
    Eigen::MatrixXd curvature = Eigen::MatrixXd::Zero(observed, observed);
    curvature.topLeftCorner(geometry_, geometry_) = curvature_;
    curvature.bottomRightCorner(by_color.cols(), by_color.cols()) = all;
    curvature_ = curvature;
  }

  /** \brief A camera has a part in a motion if its twist is over this share of it, squared. */
  static constexpr double kPart = 1e-3;
  /** \brief Colour tells a motion if of what one image seems to tell the other one shows at least this share, too. */
  static constexpr double kShared = 0.1;
  /** \brief At most this share of what tells a motion is put down to noise. */
  static constexpr double kNoiseShare = 0.9;

  Eigen::Index size_;
  Eigen::MatrixXd H_, S_, C_;
  Eigen::MatrixXd B_;  ///< the part of C that both images show
  Eigen::VectorXd g_, g_color_;
  double min_information_{0};
  std::optional<ColorRole> color_;
  bool all_observable_{false};
  bool asks_color_{false};
  bool has_modes_{true};  ///< of nothing, to begin with
  bool plain_{false};     ///< observable_ are the twists themselves
  Eigen::MatrixXd
      observable_;  ///< motions that geometry tells, modes the weakest first, then those that only colour does
  Eigen::MatrixXd curvature_;  ///< of the squared residuals along them
  Eigen::Index geometry_{0};   ///< of observable_, those that geometry tells
  Eigen::MatrixXd shared_;     ///< of C along the others, what both images show
  Eigen::Index free_{0};
  Eigen::MatrixXd free_modes_;    ///< what geometry does not tell; orthonormal by S
  Eigen::MatrixXd free_motions_;  ///< orthonormal columns
};

}  // namespace host
}  // namespace fuse_flow
