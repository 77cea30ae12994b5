#pragma once

#include <fuse_flow/calibration/coarse_alignment.h>
#include <fuse_flow/impl/calibration/alignment_system.hpp>
#include <fuse_flow/impl/calibration/coarse/brightness_correlation.hpp>
#include <fuse_flow/impl/calibration/dense_algebra.hpp>

#include <limits>

namespace fuse_flow {
namespace host {

/** \brief A pose of one camera relative to another, and what their views make of it. */
struct PoseHypothesis {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  double score{0};
  double color_spread{0};    ///< of ViewAgreement
  double color_evidence{0};  ///< of ViewAgreement
};

/** \brief Whether two poses differ enough to count as distinct. */
inline bool distinct(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double distance, double angle) {
  return (a.translation() - b.translation()).squaredNorm() > distance * distance ||
         (a.linear().transpose() * b.linear()).trace() < 1 + 2 * std::cos(angle);
}

/** \brief Compares the views of two cameras at a relative pose, by the points of each in the depth image of the other, and
 *  improves the pose by the same correspondences. */
class ViewComparison {
 public:
  ViewComparison(const AlignmentSystem& system, const CoarseAlignmentParameters& parameters)
      : system_(system), tolerance_(parameters.tolerance) {
    for (std::size_t t = 0; t < system.instants(); ++t)
      for (std::size_t i = 0; i < system.cameras(); ++i)
        details_.push_back(findDetails(system.view(t, i), static_cast<std::size_t>(parameters.samples)));
  }

  /** \param T_first_second pose of the second camera in the frame of the first */
  ViewAgreement compare(std::size_t first, std::size_t second, const Eigen::Isometry3d& T_first_second) const {
    ViewAgreement sum;
    Differences differences;
    const double weight =
        forEachView(first, second, T_first_second,
                    [&](const AlignmentView& view, std::size_t t, std::size_t other, const RigidTransform& T) {
                      differences.sign = other == first ? 1 : -1;
                      addDetails(view, details_[t * system_.cameras() + other], T, sum);
                      return addSurfaces(view, system_.samples(t, other), T, 0, 1, sum, differences);
                    });
    const double instants = static_cast<double>(system_.instants()) / weight;
    sum.confirmed /= instants;
    sum.unlike /= instants;
    sum.contradicted /= instants;
    sum.color_spread = differences.deviation();
    sum.color_evidence = differences.correlation.evidence() / std::sqrt(instants);
    // Two views of one surface differ as much as views of this rig usually do. How much two places of equal shape differ is unknown.
    const double excess = std::pow(sum.color_spread / color_noise_, 2) - 1;
    sum.likeness = excess > 0 ? std::exp(-0.5 * excess) : 1.0;
    return sum;
  }

  /** \brief How much the brightness of views differs that see the same, grey levels. */
  void setColorNoise(double noise) { color_noise_ = noise; }

  /** \brief What two views make of a first guess. */
  struct RoughAgreement {
    double score;           ///< what it is judged by where shape is looked at
    double color_evidence;  ///< … and where colour is; as in ViewAgreement
  };

  /** \brief The same for a first guess, from every other point and without the details, which demand more. \param error of the
   *  guess, metres */
  RoughAgreement compareRoughly(std::size_t first, std::size_t second, const Eigen::Isometry3d& T_first_second,
                                float error) const {
    ViewAgreement sum;
    Differences differences;
    const double weight =
        forEachView(first, second, T_first_second,
                    [&](const AlignmentView& view, std::size_t t, std::size_t other, const RigidTransform& T) {
                      differences.sign = other == first ? 1 : -1;
                      return 2 * addSurfaces(view, system_.samples(t, other), T, error, 2, sum, differences);
                    });
    return {weight * (sum.confirmed - sum.unlike - kRoughContradiction * sum.contradicted),
            std::sqrt(weight) * differences.correlation.evidence()};
  }

  /** \brief One camera's pose improved against others, which stay. \param gates largest distance of counterparts, iteration by
   *  iteration, metres; not empty */
  Eigen::Isometry3d refine(std::size_t camera, const Eigen::Isometry3d& T, const std::vector<std::size_t>& others,
                           const std::vector<Eigen::Isometry3d>& poses, const std::vector<float>& gates) const {
    const Eigen::Isometry3d free = leastSquares(camera, T, others, poses, gates);
    const Eigen::Isometry3d guarded = descend(camera, T, others, poses, gates, true);
    return scoreWithin(camera, free, others, poses, gates.back()) >
                   scoreWithin(camera, guarded, others, poses, gates.back())
               ? free
               : guarded;
  }

  /** \brief The same without a look at how well the views agree after a step: farther off where they share little, nearer to the
   *  truth where they share much. */
  Eigen::Isometry3d leastSquares(std::size_t camera, const Eigen::Isometry3d& T, const std::vector<std::size_t>& others,
                                 const std::vector<Eigen::Isometry3d>& poses, const std::vector<float>& gates) const {
    return descend(camera, T, others, poses, gates, false);
  }

 private:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  /** \brief Between the brightness of two views, point by point. */
  struct Differences {
    double sign{1};  ///< +1: points of the first view in the second; −1: the other way round
    double count{0}, weight{0}, sum{0}, squares{0};
    BrightnessCorrelation correlation;
    /** \param here grey level of a point  \param there of the view that it lies in  \param contrast around the point, grey levels:
     *  there a difference is the work of the smallest error of depth or pose */
    void add(double here, double there, double contrast) {
      constexpr double plain = 3;
      const double difference = here - there;
      correlation.add(sign > 0 ? here : there, sign > 0 ? there : here);
      const double w = 1 / (1 + std::pow(contrast / plain, 2));
      count += 1;
      weight += w;
      sum += w * sign * difference;
      squares += w * difference * difference;
    }
    double deviation() const {
      constexpr double enough = 30;
      if (count < enough) return 0;
      return std::sqrt(std::max(0.0, squares / weight - std::pow(sum / weight, 2)));
    }
  };

  /** \brief Cosine of the largest angle between the normals of counterparts. */
  static constexpr float kNormalCosine = 0.5f;
  /** \brief Standard deviation where nothing is smooth, over depth. */
  static constexpr float kEdgeNoise = 0.01f;
  /** \brief Confirmations that one contradiction of a first guess outweighs: few, since small errors make many of them. */
  static constexpr double kRoughContradiction = 3;
  /** \brief Difference of grey levels that two cameras' exposures may make. */
  static constexpr float kGreyLimit = 40;
  /** \brief Of AlignmentView's scales the one at which some centimetres do not matter. */
  static constexpr int kColorScale = 2;
  /** \brief Noise that a point may be off, standard deviations. */
  static constexpr float kDeviations = 3;

  /** \brief Value added to the diagonal of the normal equations, divided by the mean of the diagonal. The first value fixes only
   *  unobservable directions; the last one fixes all directions except those that most points determine. */
  static constexpr double kCautions[] = {1e-4, 0.02, 0.3};

  /** \brief Least squares, gate by gate. Where the views share little more than a floor, what pulls along it are false
   *  counterparts. \param guarded a step, bold or cautious, counts only if the views agree better after it; else every bold one
   *  does, which comes farther where the views share much */
  Eigen::Isometry3d descend(std::size_t camera, Eigen::Isometry3d T, const std::vector<std::size_t>& others,
                            const std::vector<Eigen::Isometry3d>& poses, const std::vector<float>& gates,
                            bool guarded) const {
    for (const float gate : gates) {
      Matrix6 A = Matrix6::Zero();
      Vector6 g = Vector6::Zero();
      for (const std::size_t other : others) {
        const Eigen::Isometry3d T_camera_other = T.inverse() * poses[other];
        Matrix6 A_pair = Matrix6::Zero();
        Vector6 g_pair = Vector6::Zero();
        const double weight = forEachInstant(camera, other, [&](std::size_t t) {
          return addResiduals(system_.view(t, other), system_.samples(t, camera), T_camera_other.inverse(),
                              poses[other], T.translation(), gate, 1, A_pair, g_pair) +
                 addResiduals(system_.view(t, camera), system_.samples(t, other), T_camera_other, T, T.translation(),
                              gate, -1, A_pair, g_pair);
        });
        A += weight * A_pair;
        g += weight * g_pair;
      }
      if (!(A.trace() > 0)) return T;
      if (!guarded) {
        T = stepped(T, A, g, kCautions[0]);
        continue;
      }
      const Eigen::Isometry3d start = T;
      double best = scoreWithin(camera, T, others, poses, gate);
      for (const double caution : kCautions) {
        const Eigen::Isometry3d next = stepped(start, A, g, caution);
        const double score = scoreWithin(camera, next, others, poses, gate);
        if (!(score > best)) continue;
        best = score;
        T = next;
      }
    }
    return T;
  }

  /** \brief How well a camera agrees with others, for all that an error tells. */
  double scoreWithin(std::size_t camera, const Eigen::Isometry3d& T, const std::vector<std::size_t>& others,
                     const std::vector<Eigen::Isometry3d>& poses, float error) const {
    double sum = 0;
    for (const std::size_t other : others) {
      const Eigen::Isometry3d T_other_camera = poses[other].inverse() * T;
      sum += error > 2 * tolerance_ ? compareRoughly(other, camera, T_other_camera, error).score
                                    : compare(other, camera, T_other_camera).score();
    }
    return sum;
  }

  /** \brief A pose after a step about its own centre. */
  static Eigen::Isometry3d stepped(const Eigen::Isometry3d& T, Matrix6 A, const Vector6& g, double caution) {
    A.diagonal().array() += caution / 6 * A.trace();
    const Vector6 twist = CholeskyFactors(A).solve(-g);
    const double angle = twist.tail<3>().norm();
    if (!(angle < 0.5 && twist.head<3>().norm() < 1.0)) return T;
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    if (angle > 0) motion.linear() = Eigen::AngleAxisd(angle, twist.tail<3>() / angle).toRotationMatrix();
    motion.translation() = twist.head<3>();
    const Eigen::Translation3d center(T.translation());
    return center * motion * center.inverse() * T;
  }

  /** \brief Calls look(t) for instants at which both have a view: for all of them unless the views share most of what they see. Then few
   *  tell as much as all do elsewhere, and all would take several times as long.
   *  \param look returns how many points of one view lie in the image of the other  \returns instants there are, over those looked at */
  template <typename Look>
  double forEachInstant(std::size_t first, std::size_t second, const Look& look) const {
    constexpr std::size_t enough = 3000;  // points: of all of ten instants with the default samples, a quarter
    std::size_t both = 0, looked_at = 0, step = 1, next = 0;
    for (std::size_t t = 0; t < system_.instants(); ++t) {
      if (system_.view(t, first).missing() || system_.view(t, second).missing()) continue;
      if (both++ != next) continue;
      const std::size_t met = look(t);
      if (looked_at++ == 0) step = std::max<std::size_t>(1, met * system_.instants() / enough);
      next += step;
    }
    return looked_at > 0 ? static_cast<double>(both) / static_cast<double>(looked_at) : 1.0;
  }

  template <typename Visit>
  double forEachView(std::size_t first, std::size_t second, const Eigen::Isometry3d& T_first_second,
                     const Visit& visit) const {
    const RigidTransform forth = toRigidTransform(T_first_second), back = toRigidTransform(T_first_second.inverse());
    return forEachInstant(first, second, [&](std::size_t t) {
      return visit(system_.view(t, first), t, second, forth) + visit(system_.view(t, second), t, first, back);
    });
  }

  /** \brief Points without a normal: of things too small or too round for one. */
  static std::vector<Vec3> findDetails(const AlignmentView& view, std::size_t count) {
    std::vector<Vec3> all;
    if (view.missing()) return all;
    for (int v = 2; v < view.height() - 2; ++v)
      for (int u = 2; u < view.width() - 2; ++u)
        if (view.point(u, v).z > 0 && !(squaredNorm(view.normal(u, v)) > 0)) all.push_back(view.point(u, v));
    std::vector<Vec3> chosen;
    const std::size_t n = std::min(count, all.size());
    for (std::size_t k = 0; k < n; ++k) chosen.push_back(all[k * all.size() / n]);
    return chosen;
  }

  /** \returns how many of the points that were looked at lie in the image */
  std::size_t addSurfaces(const AlignmentView& view, const std::vector<AlignmentSample>& samples,
                          const RigidTransform& T, float error, std::size_t stride, ViewAgreement& sum,
                          Differences& differences) const {
    std::size_t located = 0;
    for (std::size_t k = 0; k < samples.size(); k += stride) {
      const AlignmentSample& s = samples[k];
      const Vec3 q = T * s.p;
      int u, v;
      if (!view.locate(q, u, v)) continue;
      ++located;
      const Vec3 d = view.point(u, v);
      if (!(d.z > 0)) continue;
      const Vec3& n = view.normal(u, v);
      const Vec3 n_q = rotate(T, s.n);
      const bool smooth = squaredNorm(n) > 0;
      const float noise = smooth ? view.noise(u, v) : kEdgeNoise * d.z;
      const float reach = tolerance_ + error + kDeviations * std::sqrt(s.noise * s.noise + noise * noise);
      if (smooth && std::fabs(dot(n, q - d)) < reach) {
        if (dot(n_q, q) > 0) continue;  // the other side of something thin
        const bool colored = view.hasColor() && s.luma[0] >= 0 && view.luma(u, v) >= 0;
        const bool painted = colored && std::fabs(view.luma(u, v) - s.luma[0]) > kGreyLimit;
        const bool faces = dot(n, n_q) >= kNormalCosine;
        ++(painted || !faces ? sum.unlike : sum.confirmed);
        if (faces && colored) {
          const float here = s.luma[kColorScale], there = view.luma(u, v, kColorScale);
          const float contrast =
              std::max(std::fabs(s.luma[kColorScale - 1] - here), std::fabs(view.luma(u, v, kColorScale - 1) - there)) +
              std::max(std::fabs(s.luma[kColorScale + 1] - here), std::fabs(view.luma(u, v, kColorScale + 1) - there));
          differences.add(static_cast<double>(here), static_cast<double>(there), static_cast<double>(contrast));
        }
      } else if (q.z < d.z && seenThrough(view, u, v, q.z + 2 * reach)) {
        ++sum.contradicted;
      }
    }
    return located;
  }

  void addDetails(const AlignmentView& view, const std::vector<Vec3>& details, const RigidTransform& T,
                  ViewAgreement& sum) const {
    for (const Vec3& p : details) {
      const Vec3 q = T * p;
      int u, v;
      if (!view.locate(q, u, v)) continue;
      const float z = view.point(u, v).z;
      if (z > q.z && seenThrough(view, u, v, q.z + 2 * (tolerance_ + kDeviations * kEdgeNoise * z))) ++sum.contradicted;
    }
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

  /** \param sign +1: the points move, −1: the image does  \returns how many points lie in the image */
  static std::size_t addResiduals(const AlignmentView& view, const std::vector<AlignmentSample>& samples,
                                  const Eigen::Isometry3d& T_view_samples, const Eigen::Isometry3d& T_view,
                                  const Eigen::Vector3d& center, float gate, double sign, Matrix6& A, Vector6& g) {
    const RigidTransform T = toRigidTransform(T_view_samples);
    const RigidTransform to_center = toRigidTransform(Eigen::Translation3d(-center) * T_view);
    const int scale = gate < 0.06f ? 1 : gate < 0.2f ? 2 : 3;  // blurred as widely as points are off
    AlignmentSums sums{};
    std::vector<Correspondence> colors;
    std::size_t located = 0;
    for (const AlignmentSample& s : samples) {
      const Vec3 q = T * s.p;
      int u, v;
      if (!view.locate(q, u, v)) continue;
      ++located;
      const Vec3& n = view.normal(u, v);
      if (!(squaredNorm(n) > 0) || !(dot(n, rotate(T, s.n)) > kNormalCosine)) continue;
      const Vec3 e = q - view.point(u, v);
      const float noise = view.noise(u, v);
      const float reach = gate + kDeviations * std::sqrt(s.noise * s.noise + noise * noise);
      if (!(squaredNorm(e) < 4 * reach * reach)) continue;
      const float r = dot(n, e);
      addCorrespondence(sums, to_center * q, rotate(to_center, n), r, tukeyWeight(r, reach));
      GreySlope grey;
      if (std::fabs(r) < reach && s.luma[scale] >= 0 && findGreySlope(view.image(), scale, q, grey))
        colors.push_back({to_center * q, rotate(to_center, grey.gradient), grey.level - s.luma[scale], 0, {}});
    }
    addColors(colors, sums);
    int k = 0;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column, ++k) {
        A(row, column) += sums.A[k];
        if (column != row) A(column, row) += sums.A[k];
      }
      g[row] += sign * sums.g[row];
    }
    return located;
  }

  /** \brief Differences of brightness, but for what all have in common. */
  static void addColors(const std::vector<Correspondence>& colors, AlignmentSums& sums) {
    constexpr std::size_t fewest = 30;
    constexpr float grey_level = 0.01f;  // metres of distance that one counts as much as
    constexpr float largest = 20;        // grey levels
    if (colors.size() < fewest) return;
    double sum = 0;
    for (const Correspondence& c : colors) sum += static_cast<double>(c.r);
    const auto mean = static_cast<float>(sum / static_cast<double>(colors.size()));
    for (const Correspondence& c : colors)
      addCorrespondence(sums, c.x, c.n, c.r - mean, grey_level * grey_level * tukeyWeight(c.r - mean, largest));
  }

  const AlignmentSystem& system_;
  float tolerance_;
  double color_noise_{std::numeric_limits<double>::infinity()};  ///< until it is known, colour is not used
  std::vector<std::vector<Vec3>> details_;                       ///< instant by instant, camera by camera
};

}  // namespace host
}  // namespace fuse_flow
