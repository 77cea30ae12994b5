#pragma once

#include <fuse_flow/coarse_alignment.h>
#include <fuse_flow/impl/host/alignment_system.hpp>

#include <Eigen/Cholesky>

namespace fuse_flow {
namespace host {

/** \brief A pose of one camera relative to another, and what their views make of it. */
struct PoseHypothesis {
  Eigen::Isometry3d T{Eigen::Isometry3d::Identity()};
  double score{0};
};

/** \brief Whether two poses would be told apart. */
inline bool distinct(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double distance, double angle) {
  return (a.translation() - b.translation()).squaredNorm() > distance * distance ||
         (a.linear().transpose() * b.linear()).trace() < 1 + 2 * std::cos(angle);
}

/** \brief Compares the views of two cameras at a relative pose, by the points of each in the depth image of the other, and
 *  improves the pose by the same correspondences. */
class ViewComparison {
 public:
  ViewComparison(const AlignmentSystem& system, const CoarseAlignmentParameters& parameters)
      : system_(system), tolerance_(parameters.tolerance) {}

  /** \param T_first_second pose of the second camera in the frame of the first  \param extra tolerance beyond that of the
   *  parameters, metres: what the pose is off */
  ViewAgreement compare(std::size_t first, std::size_t second, const Eigen::Isometry3d& T_first_second, float extra,
                        std::size_t stride = 1) const {
    ViewAgreement sum;
    const RigidTransform forth = toRigidTransform(T_first_second), back = toRigidTransform(T_first_second.inverse());
    for (std::size_t t = 0; t < system_.instants(); ++t) {
      if (system_.view(t, first).missing() || system_.view(t, second).missing()) continue;
      addAgreement(system_.view(t, first), system_.samples(t, second), forth, extra, stride, sum);
      addAgreement(system_.view(t, second), system_.samples(t, first), back, extra, stride, sum);
    }
    return sum;
  }

  /** \brief One camera's pose improved against others, which stay. \param gates largest distance of counterparts, iteration by
   *  iteration, metres */
  Eigen::Isometry3d refine(std::size_t camera, Eigen::Isometry3d T, const std::vector<std::size_t>& others,
                           const std::vector<Eigen::Isometry3d>& poses, const std::vector<float>& gates) const {
    for (const float gate : gates) {
      const Eigen::Vector3d center = T.translation();
      Matrix6 A = Matrix6::Zero();
      Vector6 g = Vector6::Zero();
      for (const std::size_t other : others) {
        const Eigen::Isometry3d T_camera_other = T.inverse() * poses[other];
        for (std::size_t t = 0; t < system_.instants(); ++t) {
          if (system_.view(t, camera).missing() || system_.view(t, other).missing()) continue;
          addResiduals(system_.view(t, other), system_.samples(t, camera), T_camera_other.inverse(), poses[other], center,
                       gate, 1, A, g);
          addResiduals(system_.view(t, camera), system_.samples(t, other), T_camera_other, T, center, gate, -1, A, g);
        }
      }
      if (!(A.trace() > 0)) return T;
      // Directions that nothing tells stay where they are.
      A.diagonal().array() += 1e-3 * A.trace() / 6;
      const Vector6 twist = A.ldlt().solve(-g);
      const double angle = twist.tail<3>().norm();
      if (!(angle < 0.5 && twist.head<3>().norm() < 1.0)) return T;
      Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
      if (angle > 0) motion.linear() = Eigen::AngleAxisd(angle, twist.tail<3>() / angle).toRotationMatrix();
      motion.translation() = twist.head<3>();
      T = Eigen::Translation3d(center) * motion * Eigen::Translation3d(-center) * T;
    }
    return T;
  }

 private:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  /** \brief Cosine of the largest angle between the normals of counterparts. */
  static constexpr float kNormalCosine = 0.5f;
  /** \brief Difference of grey levels that two cameras' exposures may make. */
  static constexpr float kGreyLimit = 40;
  /** \brief Noise that a point may be off, standard deviations. */
  static constexpr float kDeviations = 3;

  void addAgreement(const AlignmentView& view, const std::vector<AlignmentSample>& samples, const RigidTransform& T,
                    float extra, std::size_t stride, ViewAgreement& sum) const {
    std::size_t confirmed = 0, contradicted = 0, discolored = 0;
    for (std::size_t k = 0; k < samples.size(); k += stride) {
      const AlignmentSample& s = samples[k];
      const Vec3 q = T * s.p;
      int u, v;
      if (!view.locate(q, u, v)) continue;
      const Vec3 d = view.point(u, v);
      if (!(d.z > 0)) continue;
      const Vec3& n = view.normal(u, v);
      const Vec3 n_q = rotate(T, s.n);
      const bool smooth = squaredNorm(n) > 0;
      const float noise = smooth ? view.noise(u, v) : 0.01f * d.z;
      const float reach = tolerance_ + extra + kDeviations * std::sqrt(s.noise * s.noise + noise * noise);
      if (smooth && std::fabs(dot(n, q - d)) < reach) {
        if (dot(n_q, q) > 0) continue;  // the other side of something thin
        const bool alike = dot(n, n_q) > kNormalCosine;
        const bool painted = alike && view.hasColor() && s.luma >= 0 && std::fabs(view.luma(u, v) - s.luma) > kGreyLimit;
        ++(painted ? discolored : alike ? confirmed : contradicted);
      } else if (q.z < d.z && seenThrough(view, u, v, q.z + 2 * reach)) {
        ++contradicted;
      }
    }
    sum.confirmed += static_cast<double>(confirmed);
    sum.contradicted += static_cast<double>(contradicted);
    sum.discolored += static_cast<double>(discolored);
  }

  /** \brief Whether all around a pixel the first surface lies beyond z: at edges a pose that is a little off proves nothing. */
  static bool seenThrough(const AlignmentView& view, int u, int v, float z) {
    for (int b = std::max(0, v - 1); b <= std::min(view.height() - 1, v + 1); ++b)
      for (int a = std::max(0, u - 1); a <= std::min(view.width() - 1, u + 1); ++a) {
        const float there = view.point(a, b).z;
        if (there > 0 && there < z) return false;
      }
    return true;
  }

  /** \param sign +1: the points move, −1: the image does */
  static void addResiduals(const AlignmentView& view, const std::vector<AlignmentSample>& samples,
                           const Eigen::Isometry3d& T_view_samples, const Eigen::Isometry3d& T_view,
                           const Eigen::Vector3d& center, float gate, double sign, Matrix6& A, Vector6& g) {
    const RigidTransform T = toRigidTransform(T_view_samples);
    const RigidTransform to_center = toRigidTransform(Eigen::Translation3d(-center) * T_view);
    AlignmentSums sums{};
    for (const AlignmentSample& s : samples) {
      const Vec3 q = T * s.p;
      int u, v;
      if (!view.locate(q, u, v)) continue;
      const Vec3& n = view.normal(u, v);
      if (!(squaredNorm(n) > 0) || !(dot(n, rotate(T, s.n)) > kNormalCosine)) continue;
      const Vec3 e = q - view.point(u, v);
      if (!(squaredNorm(e) < 4 * gate * gate)) continue;
      const float r = dot(n, e);
      addCorrespondence(sums, to_center * q, rotate(to_center, n), r, tukeyWeight(r, gate));
    }
    int k = 0;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column, ++k) {
        A(row, column) += sums.A[k];
        if (column != row) A(column, row) += sums.A[k];
      }
      g[row] += sign * sums.g[row];
    }
  }

  const AlignmentSystem& system_;
  float tolerance_;
};

}  // namespace host
}  // namespace fuse_flow
