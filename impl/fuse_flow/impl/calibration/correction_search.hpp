#pragma once

#include <fuse_flow/calibration/depth_correction_estimation.h>
#include <fuse_flow/impl/calibration/alignment_system.hpp>
#include <fuse_flow/impl/calibration/twist.hpp>

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace fuse_flow {
namespace host {

/** \brief Where a pixel lies between the knots of a correction: their numbers, and how much each counts. */
struct KnotWeights {
  std::array<int, 4> knot;
  std::array<float, 4> weight;
};

/** \brief The knots of a correction. */
class KnotGrid {
 public:
  KnotGrid(int columns, int rows) : columns_(columns), rows_(rows) {}

  int knots() const { return columns_ * rows_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }

  /** \brief As betweenKnots(). \param u pixels, to the centre of one  \param v the same */
  KnotWeights at(float u, float v, const Intrinsics& K) const {
    const float x = along(u, K.width, columns_), y = along(v, K.height, rows_);
    const int i = std::min(static_cast<int>(x), columns_ - 2), j = std::min(static_cast<int>(y), rows_ - 2);
    const float right = x - static_cast<float>(i), down = y - static_cast<float>(j);
    const int k = j * columns_ + i;
    return {{k, k + 1, k + columns_, k + columns_ + 1},
            {(1 - right) * (1 - down), right * (1 - down), (1 - right) * down, right * down}};
  }

 private:
  static float along(float pixel, int pixels, int knots) {
    if (pixels < 2) return 0;
    const auto last = static_cast<float>(knots - 1);
    return clampTo(pixel * last / static_cast<float>(pixels - 1), 0.0f, last);
  }

  int columns_, rows_;
};

/** \brief A block of a view, corrected. */
struct CorrectedBlock {
  KnotWeights at;
  float z;        ///< as measured, metres
  float z_right;  ///< corrected, metres
  float growth;   ///< by how much z_right grows with z
  /** \brief What would have been measured without noise, as far as the counterpart tells, metres. How the residual grows with a and b
   *  is taken there: at z itself it is noisy, and noise that is in both the residual and what changes it pulls depth towards the
   *  camera, the more the farther and so the noisier it is. */
  float z_likely;

  /** \brief Derivative of the residual of a plane with respect to the measured z. \param along the same for z_right */
  float slope(float along) const { return growth * along; }

  /** \brief Sets z_likely. \param noise the part of the residual that is this measurement's own noise, metres  \param along see slope() */
  void takeBack(float noise, float along) {
    constexpr float least = 0.2f;  // as for normals: surfaces at a grazing angle are measured badly
    const float s = slope(along);
    z_likely = z * depthRatio(-noise, z * (s < 0 ? std::min(s, -least) : std::max(s, least)));
  }
};

/** \brief z (1 + a + b z), as DepthCorrection has it. \param z metres, > 0  \param a,b between the knots; b in 1/metres */
inline CorrectedBlock correctBlock(const KnotWeights& at, float z, double a, double b) {
  const float right = correctedDepth(z, {static_cast<float>(a), static_cast<float>(b)});
  return {at, z, right, static_cast<float>(1 + a + 2 * b * static_cast<double>(z)), z};
}

/** \brief A sample and its correspondence: the residual and its derivatives. */
struct CorrectedPair {
  CorrectedBlock own, other;
  Vec3 x;              ///< of the corrected sample, scene, metres
  Vec3 n;              ///< normal of the counterpart, scene
  float along_own;     ///< derivative of the residual with respect to the sample's corrected depth
  float along_other;   ///< the same for the correspondence
  float r, per_sigma;  ///< metres, and over its standard deviation

  /** \brief Sets z_likely of both, the depths without noise. \return variance of r at these depths, square metres
   *
   *  The residual is divided between the two measurements in proportion to their variances in the residual. Such a variance includes the
   *  stretch by the correction, and is measured along the normal; because rays are oblique, this is not the component along the optical
   *  axis. With wrong shares, some noise remains in the derivatives of the residual, and moves the solution along weakly determined
   *  directions. In the worst case this does not converge: a correction that shortened depth left some noise, which shortened depth
   *  further.
   *  \param image of the sample  \param other_image of the counterpart */
  float shareResidual(const BlockImage& image, const BlockImage& other_image) {
    const auto variance = [](const BlockImage& of, float z, float slope) {
      const float deviation = slope * of.axialDeviation(z);
      return deviation * deviation;
    };
    const float slope_own = own.slope(along_own), slope_other = other.slope(along_other);
    const float of_own = variance(image, own.z, slope_own), of_other = variance(other_image, other.z, slope_other);
    const float rounding = kBlockFloor * kBlockFloor, whole = of_own + of_other + rounding;
    own.takeBack(r * of_own / whole, along_own);
    other.takeBack(r * of_other / whole, along_other);
    return variance(image, own.z_likely, slope_own) + variance(other_image, other.z_likely, slope_other) + rounding;
  }
};

/** \brief One search for the corrections and the poses of a rig, about the scene's centre. Unknowns: a twist of each camera, metres at the
 *  scene's radius, and then, for each correction, a and b of its knots, alternately. */
class CorrectionSearch {
 public:
  CorrectionSearch(AlignmentSystem& system, const DepthCorrectionParameters& parameters,
                   const std::vector<Camera>& cameras, const std::vector<Eigen::Isometry3d>& initial, int threads)
      : system_(system),
        p_(parameters),
        cameras_(cameras),
        initial_(initial),
        threads_(threads),
        grid_(parameters.columns, parameters.rows),
        of_correction_(2 * grid_.knots()),
        poses_(initial),
        normal_cosine_(std::cos(parameters.views.max_normal_angle)) {}

  /** \param compared poses that have no corrections, to be measured beside; null: none */
  DepthCorrectionResult run(const std::vector<Eigen::Isometry3d>* compared = nullptr) {
    system_.sample(initial_, p_.views.samples);
    const SceneExtent extent = system_.extent(initial_);
    center_ = extent.center;
    radius_ = extent.radius;
    for (Eigen::Isometry3d& T : poses_) T = Eigen::Translation3d(-center_) * T;
    const Eigen::Index corrections = p_.shared ? 1 : count();
    unknowns_ = 6 * count() + corrections * of_correction_;
    knots_ = Eigen::VectorXd::Zero(corrections * of_correction_);
    moved_ = Eigen::VectorXd::Zero(6 * count());

    gate_ = p_.views.max_correspondence_distance;
    const AlignmentGates gates{gate_, kDeviations, normal_cosine_, 1e9f, 0, 0, false, 0, 1};
    system_.findNeighbours(poses_, gates, p_.views.max_neighbours);
    measureDepths();
    DepthCorrectionResult result;
    std::size_t matches = 0;
    result.residual_before = residual(matches);
    if (compared != nullptr) {
      result.compared = true;
      const std::vector<Eigen::Isometry3d> own = poses_;
      for (std::size_t i = 0; i < poses_.size(); ++i) poses_[i] = Eigen::Translation3d(-center_) * (*compared)[i];
      result.residual_of_poses = residual(result.correspondences_of_poses);
      poses_ = own;
    }
    Eigen::VectorXd last;
    bool narrow = false;
    int still = 0;
    for (result.iterations = 1; result.iterations <= p_.views.max_iterations && count() > 1; ++result.iterations) {
      linearize(narrow ? 0.0f : 0.5f * gate_);
      Eigen::VectorXd step = solve();
      if (last.size() > 0 && step.dot(last) < 0) step *= 0.5;
      last = step;
      const double moved = apply(step);
      narrow = gate_ <= p_.views.min_correspondence_distance;
      gate_ = std::max(p_.views.min_correspondence_distance, kNarrower * gate_);
      tukey_ = kTukey * std::max(1.0f, 1.4826f * median_);
      still = narrow && moved < kStill ? still + 1 : 0;
      if (still == 2) {
        result.converged = true;
        break;
      }
    }
    result.iterations = std::min(result.iterations, p_.views.max_iterations);
    fixGauge();
    gate_ = p_.views.max_correspondence_distance;
    result.residual = residual(result.correspondences);
    describe(result);
    return result;
  }

 private:
  Eigen::Index count() const { return static_cast<Eigen::Index>(initial_.size()); }
  /** \brief Number of the first knot of a camera's correction among the unknowns. */
  Eigen::Index firstKnot(std::size_t camera) const {
    return 6 * count() + (p_.shared ? 0 : static_cast<Eigen::Index>(camera) * of_correction_);
  }

  CorrectedBlock correct(std::size_t camera, float u, float v, const BlockImage& image, float z) const {
    const KnotWeights at = grid_.at(u, v, image.intrinsics);
    const double* knots = knots_.data() + (firstKnot(camera) - 6 * count());
    double a = 0, b = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      a += static_cast<double>(at.weight[k]) * knots[2 * at.knot[k]];
      b += static_cast<double>(at.weight[k]) * knots[2 * at.knot[k] + 1];
    }
    return correctBlock(at, z, a, b);
  }
  /** \brief Pixel of the middle of a block. */
  static float middle(int block, int reduction) {
    return static_cast<float>(block * reduction) + 0.5f * static_cast<float>(reduction - 1);
  }

  bool pair(std::size_t i, std::size_t j, const BlockImage& image, const BlockImage& other,
            const AlignmentSample& sample, CorrectedPair& out) const {
    const Pixel place = image.project(sample.p);
    const auto reduction = static_cast<float>(image.reduction);
    out.own = correct(i, reduction * place.u - 0.5f, reduction * place.v - 0.5f, image, sample.p.z);
    const Vec3 ray = (1.0f / sample.p.z) * sample.p;
    out.x = places_[i].to_world * (out.own.z_right * ray);
    const Vec3 q = places_[j].to_camera * out.x;
    int u = 0, v = 0;
    if (!other.locate(q, u, v)) return false;
    const float z = other.depth(u, v);
    if (!(z > 0)) return false;
    const Vec3& n = other.normal(u, v);
    if (!(squaredNorm(n) > 0)) return false;
    out.other = correct(j, middle(u, other.reduction), middle(v, other.reduction), other, z);
    const Vec3 ray_j = (1.0f / z) * other.point(u, v);
    out.n = rotate(places_[j].to_world, n);
    if (!(dot(out.n, rotate(places_[i].to_world, sample.n)) > normal_cosine_)) return false;
    out.r = dot(n, q - out.other.z_right * ray_j);
    out.along_own = dot(out.n, rotate(places_[i].to_world, ray));
    out.along_other = -dot(n, ray_j);
    const float along = q.z - out.other.z_right, variance = out.shareResidual(image, other);
    if (!(along * along < std::max(gate_ * gate_, kDeviations * kDeviations * variance))) return false;
    out.per_sigma = 1.0f / std::sqrt(variance);
    return true;
  }

  /** \brief How many instants both cameras of a pair measured at. */
  std::size_t sharedInstants(const PairSums& cameras) const {
    std::size_t shared = 0;
    for (std::size_t t = 0; t < system_.instants(); ++t)
      shared += system_.view(t, cameras.i).image().missing() || system_.view(t, cameras.j).image().missing() ? 0 : 1;
    return shared;
  }

  /** \brief Calls visit(pairing) for all correspondences of a pair of cameras, instant by instant. */
  template <typename Visit>
  void forEachPairing(const PairSums& cameras, const Visit& visit) const {
    for (std::size_t t = 0; t < system_.instants(); ++t) {
      const BlockImage& image = system_.view(t, cameras.i).image();
      const BlockImage& other = system_.view(t, cameras.j).image();
      if (image.missing() || other.missing()) continue;
      for (const AlignmentSample& sample : system_.samples(t, cameras.i)) {
        CorrectedPair pairing;
        if (pair(cameras.i, cameras.j, image, other, sample, pairing)) visit(pairing);
      }
    }
  }

  /** \brief What one ordered pair of cameras adds to the normal equations: twists of both, then the knots of both. */
  struct PairSystem {
    Eigen::MatrixXd A;  ///< lower triangle
    Eigen::VectorXd g;
    std::vector<std::uint32_t> histogram;
  };

  /** \brief \param reach Tukey's weight reaches at least so far, metres: what is well aligned must not cast out what is not yet */
  void linearize(float reach) {
    place();
    const std::vector<PairSums>& pairs = system_.pairs();
    A_ = Eigen::MatrixXd::Zero(unknowns_, unknowns_);
    g_ = Eigen::VectorXd::Zero(unknowns_);
    std::vector<std::uint32_t> histogram(kNoiseBins, 0);
    constexpr std::size_t at_once = 64;  // bounds the memory
    std::vector<PairSystem> systems(std::min(at_once, pairs.size()));
    for (std::size_t begin = 0; begin < pairs.size(); begin += at_once) {
      const std::size_t n = std::min(at_once, pairs.size() - begin);
      parallelFor(threads_, n, [&](std::size_t k, int) { addUp(pairs[begin + k], reach, systems[k]); });
      for (std::size_t k = 0; k < n; ++k) {  // in a fixed order, independent of the threads
        spread(pairs[begin + k], systems[k]);
        for (std::size_t b = 0; b < histogram.size(); ++b) histogram[b] += systems[k].histogram[b];
      }
    }
    median_ = medianResidualOf(histogram);
  }

  void addUp(const PairSums& cameras, float reach, PairSystem& out) const {
    const Eigen::Index n = 12 + 2 * of_correction_;
    out.A = Eigen::MatrixXd::Zero(n, n);
    out.g = Eigen::VectorXd::Zero(n);
    out.histogram.assign(kNoiseBins, 0);
    const double per_radius = 1 / radius_;
    const double alike = static_cast<double>(p_.redundancy) *
                         std::max(1.0, static_cast<double>(sharedInstants(cameras)) / p_.effective_instants);
    std::array<Eigen::Index, 28> index;
    std::array<double, 28> J;
    forEachPairing(cameras, [&](const CorrectedPair& m) {
      ++out.histogram[static_cast<std::size_t>(residualBin(m.r, m.per_sigma))];
      const float weight = tukeyWeight(m.r, std::max(reach, tukey_ / m.per_sigma));
      if (!(weight > 0)) return;
      const Vec3 turn = cross(m.x, m.n);
      const double twist[6] = {m.n.x,
                               m.n.y,
                               m.n.z,
                               per_radius * static_cast<double>(turn.x),
                               per_radius * static_cast<double>(turn.y),
                               per_radius * static_cast<double>(turn.z)};
      for (std::size_t k = 0; k < 6; ++k) {
        index[k] = static_cast<Eigen::Index>(k);
        J[k] = twist[k];
        index[6 + k] = static_cast<Eigen::Index>(6 + k);
        J[6 + k] = -twist[k];
      }
      const auto putKnots = [&](std::size_t first, Eigen::Index offset, const CorrectedBlock& c, float along) {
        for (std::size_t k = 0; k < 4; ++k) {
          const double a =
              static_cast<double>(along) * static_cast<double>(c.at.weight[k]) * static_cast<double>(c.z_likely);
          index[first + 2 * k] = offset + 2 * c.at.knot[k];
          J[first + 2 * k] = a;
          index[first + 2 * k + 1] = offset + 2 * c.at.knot[k] + 1;
          J[first + 2 * k + 1] = a * static_cast<double>(c.z_likely);
        }
      };
      putKnots(12, 12, m.own, m.along_own);
      putKnots(20, 12 + of_correction_, m.other, m.along_other);
      const double w =
          static_cast<double>(weight) * static_cast<double>(m.per_sigma) * static_cast<double>(m.per_sigma) / alike;
      for (std::size_t b = 0; b < J.size(); ++b) {
        const double wJ = w * J[b];
        double* column = out.A.data() + index[b] * n;
        for (std::size_t a = b; a < J.size(); ++a) column[index[a]] += wJ * J[a];  // indices rise
        out.g[index[b]] += wJ * static_cast<double>(m.r);
      }
    });
  }

  /** \brief Adds a pair's sums to the whole. */
  void spread(const PairSums& cameras, const PairSystem& pair) {
    const std::array<Eigen::Index, 4> from{0, 6, 12, 12 + of_correction_};
    const std::array<Eigen::Index, 4> size{6, 6, of_correction_, of_correction_};
    const std::array<Eigen::Index, 4> to{6 * static_cast<Eigen::Index>(cameras.i),
                                         6 * static_cast<Eigen::Index>(cameras.j), firstKnot(cameras.i),
                                         firstKnot(cameras.j)};
    for (std::size_t b = 0; b < 4; ++b) {
      g_.segment(to[b], size[b]) += pair.g.segment(from[b], size[b]);
      for (std::size_t a = 0; a < 4; ++a) {
        for (Eigen::Index column = 0; column < size[b]; ++column)
          for (Eigen::Index row = 0; row < size[a]; ++row) {
            const Eigen::Index r = from[a] + row, c = from[b] + column;
            A_(to[a] + row, to[b] + column) += r >= c ? pair.A(r, c) : pair.A(c, r);
          }
      }
    }
  }

  /** \brief What is believed without the data; returns its information, and adds how far the state is from it to gradient. */
  Eigen::MatrixXd prior(Eigen::VectorXd& gradient) const {
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(unknowns_, unknowns_);
    const double per_pose = 1 / std::pow(static_cast<double>(p_.pose_deviation), 2);
    for (Eigen::Index k = 0; k < 6 * count(); ++k) P(k, k) = per_pose;
    const double small = 1 / std::pow(static_cast<double>(p_.magnitude), 2);
    const double smooth = 1 / std::pow(static_cast<double>(p_.roughness), 2);
    const auto alike = [&](Eigen::Index a, Eigen::Index b) {
      P(a, a) += smooth;
      P(b, b) += smooth;
      P(a, b) -= smooth;
      P(b, a) -= smooth;
    };
    for (Eigen::Index first = 6 * count(); first < unknowns_; first += of_correction_)
      for (int y = 0; y < grid_.rows(); ++y)
        for (int x = 0; x < grid_.columns(); ++x)
          for (int term = 0; term < 2; ++term) {
            const Eigen::Index k = first + 2 * (y * grid_.columns() + x) + term;
            P(k, k) += small / grid_.knots();  // all knots together are one thing
            if (x + 1 < grid_.columns()) alike(k, k + 2);
            if (y + 1 < grid_.rows()) alike(k, k + 2 * grid_.columns());
          }
    Eigen::VectorXd state(unknowns_);
    state << moved_, knots_;
    gradient += P * state;
    return P;
  }

  Eigen::VectorXd solve() {
    information_ = A_.diagonal();
    Eigen::VectorXd gradient = g_;
    Eigen::MatrixXd H = prior(gradient);
    believed_ = H.diagonal();
    H += A_;
    // The scale of the scene: as stiff as all the data.
    const double mean = scale_.dot(knots_);
    const double stiff = 1e3 * A_.diagonal().tail(knots_.size()).sum() / std::max(1e-12, scale_.squaredNorm());
    H.bottomRightCorner(knots_.size(), knots_.size()) += stiff * scale_ * scale_.transpose();
    gradient.tail(knots_.size()) += stiff * mean * scale_;
    // Camera 0 stays; fixGauge() moves all together.
    H.topRows(6).setZero();
    H.leftCols(6).setZero();
    H.topLeftCorner(6, 6).setIdentity();
    gradient.head(6).setZero();
    return Eigen::LLT<Eigen::MatrixXd>(H).solve(-gradient);
  }

  /** \brief How far anything moved, metres: the cameras, at the scene's radius, and what knots say of the depth of the samples. */
  double apply(const Eigen::VectorXd& step) {
    double most = 0;
    for (Eigen::Index i = 1; i < count(); ++i) {
      const Eigen::Matrix<double, 6, 1> twist = step.segment<6>(6 * i);
      Eigen::Isometry3d& T = poses_[static_cast<std::size_t>(i)];
      T = toMotion(twist, Eigen::Vector3d::Zero(), radius_) * T;
      most = std::max(most, twist.norm());
    }
    moved_ += step.head(6 * count());
    knots_ += step.tail(knots_.size());
    for (Eigen::Index k = 0; k < knots_.size(); k += 2) {
      const double z = depth_;
      const Eigen::Index at = 6 * count() + k;
      most = std::max(most, std::fabs(z * (step[at] + z * step[at + 1])));
    }
    return most;
  }

  /** \brief Of all samples the mean a + b z by the knots, and their mean depth. */
  void measureDepths() {
    scale_ = Eigen::VectorXd::Zero(knots_.size());
    double n = 0;
    depth_ = 0;
    for (std::size_t t = 0; t < system_.instants(); ++t)
      for (std::size_t i = 0; i < cameras_.size(); ++i) {
        const BlockImage& image = system_.view(t, i).image();
        for (const AlignmentSample& sample : system_.samples(t, i)) {
          const Pixel place = image.project(sample.p);
          const auto reduction = static_cast<float>(image.reduction);
          const KnotWeights at = grid_.at(reduction * place.u - 0.5f, reduction * place.v - 0.5f, image.intrinsics);
          for (std::size_t k = 0; k < 4; ++k) {
            const Eigen::Index knot = firstKnot(i) - 6 * count() + 2 * at.knot[k];
            scale_[knot] += static_cast<double>(at.weight[k]);
            scale_[knot + 1] += static_cast<double>(at.weight[k]) * static_cast<double>(sample.p.z);
          }
          depth_ += static_cast<double>(sample.p.z);
          n += 1;
        }
      }
    if (n == 0) return;
    scale_ /= n;
    depth_ /= n;
  }

  /** \brief Root mean square of all residuals within the gate; 0 if there are none. \param matches how many there are */
  double residual(std::size_t& matches) {
    place();
    const std::vector<PairSums>& pairs = system_.pairs();
    std::vector<double> squares(pairs.size(), 0), counts(pairs.size(), 0);
    parallelFor(threads_, pairs.size(), [&](std::size_t k, int) {
      forEachPairing(pairs[k], [&](const CorrectedPair& m) {
        squares[k] += static_cast<double>(m.r) * static_cast<double>(m.r);
        counts[k] += 1;
      });
    });
    const double n = std::accumulate(counts.begin(), counts.end(), 0.0);
    matches = static_cast<std::size_t>(n);
    return n > 0 ? std::sqrt(std::accumulate(squares.begin(), squares.end(), 0.0) / n) : 0.0;
  }

  /** \brief Lays the new poses onto the given ones, on average, unless camera 0 stays. */
  void fixGauge() {
    if (p_.views.gauge == Gauge::FirstCamera || poses_.empty()) return;
    std::vector<std::size_t> all(poses_.size());
    std::iota(all.begin(), all.end(), 0);
    const auto motion = [this](std::size_t i) -> Eigen::Isometry3d {
      return poses_[i] * (Eigen::Translation3d(-center_) * initial_[i]).inverse();
    };
    takeMeanMotionAway(all, motion, poses_);
  }

  void describe(DepthCorrectionResult& result) const {
    result.cameras = cameras_;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      Camera& camera = result.cameras[i];
      camera.T_world_camera = Eigen::Translation3d(center_) * poses_[i];
      DepthCorrection& correction = camera.depth_correction;
      correction.columns = grid_.columns();
      correction.rows = grid_.rows();
      double observable = 0;
      for (Eigen::Index k = 0; k < grid_.knots(); ++k) {
        const Eigen::Index at = firstKnot(i) + 2 * k;
        const auto limited = [](double value) { return static_cast<float>(std::clamp(value, -0.5, 0.5)); };
        correction.relative.push_back(limited(knots_[at - 6 * count()]));
        correction.per_metre.push_back(limited(knots_[at + 1 - 6 * count()]));
        if (information_.size() > 0 && information_[at] > believed_[at]) observable += 1;
      }
      result.observable.push_back(observable / grid_.knots());
    }
  }

  void place() {
    places_.resize(poses_.size());
    for (std::size_t i = 0; i < poses_.size(); ++i)
      places_[i] = {
          toRigidTransform(poses_[i]), toRigidTransform(poses_[i].inverse()), {}};  // nothing here asks for its noise
  }

  static constexpr float kDeviations = 3.0f;  ///< of noise, which the gate must not cut off
  static constexpr float kTukey = 4.685f;     ///< 95 % efficient on normal noise
  static constexpr float kNarrower = 0.7f;    ///< gate over that of the iteration before
  static constexpr double kStill = 2e-4;      ///< metres

  AlignmentSystem& system_;
  const DepthCorrectionParameters& p_;
  const std::vector<Camera>& cameras_;
  const std::vector<Eigen::Isometry3d>& initial_;
  int threads_;
  KnotGrid grid_;
  Eigen::Index of_correction_;  ///< unknowns of one correction
  Eigen::Index unknowns_{0};
  std::vector<Eigen::Isometry3d> poses_;  ///< camera → scene's centre
  Eigen::VectorXd knots_;                 ///< a and b of all corrections
  Eigen::VectorXd moved_;                 ///< twists so far, summed up
  Eigen::VectorXd scale_;                 ///< of a and b, the mean correction of all samples
  double depth_{1};                       ///< mean of the samples, metres
  Eigen::Vector3d center_{0, 0, 0};
  double radius_{1};
  float normal_cosine_;
  float gate_{0};
  float tukey_{kTukey};
  float median_{0};
  std::vector<CameraPlace> places_;
  Eigen::MatrixXd A_;
  Eigen::VectorXd g_;
  Eigen::VectorXd information_, believed_;  ///< diagonals of the last iteration
};

}  // namespace host
}  // namespace fuse_flow
