#pragma once

#include <fuse_flow/impl/calibration/pose_graph.hpp>
#include <fuse_flow/impl/calibration/pose_uncertainty.hpp>
#include <fuse_flow/impl/calibration/rig_correspondences.hpp>
#include <fuse_flow/impl/calibration/twist.hpp>

#include <cmath>
#include <numeric>

namespace fuse_flow {
namespace host {

/** \brief One search for the poses of a rig. Works about the scene's centre, so that floats and levers stay small wherever the
 *  world's origin is. */
class RigAlignment {
 public:
  RigAlignment(RigCorrespondences& system, const ExtrinsicParameters& parameters,
               const std::vector<Eigen::Isometry3d>& initial)
      : system_(system), p_(parameters), initial_(initial), starts_(rigid(initial)) {}

  ExtrinsicResult run() {
    system_.sample(starts_, p_.samples);
    findCenter();
    AlignmentGates gates{p_.max_correspondence_distance,
                         kDeviations,
                         std::cos(p_.max_normal_angle),
                         kNoLimit,
                         0.0f,
                         kGreyLimit,
                         false,
                         0,
                         kHurry};
    system_.findNeighbours(poses_, gates, p_.max_neighbours);
    measure(&CameraOverlap::residual_before, result_.residual_before);
    PoseGraph graph(system_.cameras());
    double information = std::max(kFirstInformation, static_cast<double>(p_.min_information));
    bool polishing = false;
    bool taken_back = false;
    int settling = 0;
    int at_scale = 0;
    result_.converged = system_.cameras() < 2;  // nothing to move
    for (result_.iterations = 1; !result_.converged && result_.iterations <= p_.max_iterations; ++result_.iterations) {
      if (result_.iterations == kSecondLook) system_.findNeighbours(poses_, gates, p_.max_neighbours);
      system_.evaluate(poses_, result_.scene_radius, gates);
      graph = linearize();
      graph.decompose(information, colorRole(gates));
      const double moved = apply(damped(graph.step()));
      if (gates.color && gates.scale > 0) {
        if (!graph.asksColor()) {
          gates.scale = 0;
        } else if (moved < kSettled || ++at_scale >= patience(gates.scale)) {
          --gates.scale;
          at_scale = 0;
        }
      } else if (polishing && moved < kStill) {
        if (!taken_back && takeBack(graph) > kStill) {
          taken_back = true;
          continue;
        }
        result_.converged = true;
        break;  // before the count goes on
      }
      const bool narrow = gates.distance <= p_.min_correspondence_distance && information <= p_.min_information;
      polishing = polishing || (narrow && (moved < kSettled || ++settling > kPatience));
      information = std::max(kMoreDaring * information, static_cast<double>(p_.min_information));
      gates.distance = std::max({p_.min_correspondence_distance, kNarrower * gates.distance,
                                 std::min(gates.distance, kReach * static_cast<float>(moved))});
      gates.tukey = kTukey * std::max(1.0f, 1.4826f * system_.medianResidual());
      gates.reach = polishing ? 0.0f : 0.5f * gates.distance;
      gates.stride = polishing ? 1 : kHurry;
      if (polishing && !gates.color && system_.hasColor()) {
        gates.color = true;
        gates.scale = kLumaScales - 1;
      }
    }
    result_.iterations = std::min(result_.iterations, p_.max_iterations);
    graph.findModes();
    takeBack(graph);
    fixGauge();
    describe(graph);
    measure(&CameraOverlap::residual, result_.residual);
    for (std::size_t i = 0; i < poses_.size(); ++i)  // what did not move is the same to the last digit
      result_.T_world_camera.push_back(result_.corrections[i].T_correction.isApprox(Eigen::Isometry3d::Identity(), 0)
                                           ? initial_[i]
                                           : Eigen::Isometry3d(Eigen::Translation3d(result_.scene_center) * poses_[i]));
    return std::move(result_);
  }

 private:
  /** \brief With rotations that are some. In files they have few digits; then normals have not unit length, noise of them seems to make
   *  less than nothing of a plane, and its information has no root. */
  static std::vector<Eigen::Isometry3d> rigid(std::vector<Eigen::Isometry3d> poses) {
    constexpr double exact = 1e-12;  // what is as good as that keeps its digits
    for (Eigen::Isometry3d& T : poses)
      if ((T.linear().transpose() * T.linear() - Eigen::Matrix3d::Identity()).norm() > exact)
        T.linear() = nearestRotation(T.linear());
    return poses;
  }

  void findCenter() {
    const SceneExtent extent = system_.extent(starts_);
    result_.scene_center = extent.center;
    result_.scene_radius = extent.radius;
    for (std::size_t i = 0; i < starts_.size(); ++i) poses_.push_back(start(i));
  }

  PoseGraph linearize() const {
    PoseGraph graph(system_.cameras());
    for (const PairSums& pair : system_.pairs()) {
      if (pair.geometry.count < kFewest) continue;
      graph.addGeometry(pair.i, pair.j, pair.geometry, system_.normalNoise(pair.i, pair.j));
      graph.addColor(pair.i, pair.j, pair.color, pair.color_trust);
    }
    return graph;
  }

  /** \brief Iterations for a scale of the colours; all scales must have their turn. */
  int patience(std::size_t scale) const {
    return std::min(kScalePatience, (p_.max_iterations - result_.iterations) / (static_cast<int>(scale) + 2));
  }

  static std::optional<ColorRole> colorRole(const AlignmentGates& gates) {
    if (!gates.color) return {};
    return ColorRole{kEnoughForColor, maxColorDeviation(gates.scale)};
  }

  /** \brief What colour must tell a motion to that geometry leaves open: so well that the next finer scale, which repeats itself
   *  sooner, finds the right place. The finest but one and the finest ask the same. */
  static double maxColorDeviation(std::size_t scale) {
    return kMaxColorDeviation * std::pow(kScaleTolerance, scale > 1 ? static_cast<double>(scale - 1) : 0.0);
  }

  /** \brief Half of a step that turns back on the one before. Where counterparts change with every step it is too long, poses go to
   *  and fro, and the gates, which follow how far they go, would never narrow. */
  Eigen::VectorXd damped(Eigen::VectorXd step) {
    if (last_step_.size() > 0 && step.dot(last_step_) < 0) step *= 0.5;
    last_step_ = step;
    return step;
  }

  /** \brief How far the camera moved that moved most, metres at the scene's radius. */
  double apply(const Eigen::VectorXd& step) {
    double most = 0;
    for (std::size_t i = 1; i < poses_.size(); ++i) {
      const Vector6d twist = step.segment<6>(6 * (static_cast<Eigen::Index>(i) - 1));
      poses_[i] = toMotion(twist, Eigen::Vector3d::Zero(), result_.scene_radius) * poses_[i];
      most = std::max(most, twist.norm());
    }
    return most;
  }

  /** \brief Undoes what cameras have moved along motions that seemed observable and turn out not to be. \return how far, as apply() */
  double takeBack(const PoseGraph& graph) {
    if (graph.freeMotions() == 0) return 0;
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(graph.size());
    for (std::size_t i = 1; i < poses_.size(); ++i)
      if (poses_[i].matrix() != start(i).matrix())
        moved.segment<6>(PoseGraph::begin(i)) = toTwist(correction(i), Eigen::Vector3d::Zero(), result_.scene_radius);
    const Eigen::VectorXd kept = graph.withoutFree(moved);
    double most = 0;
    for (std::size_t i = 1; i < poses_.size(); ++i) {
      const Eigen::Index k = PoseGraph::begin(i);
      if (moved.segment<6>(k).isZero(0)) continue;
      poses_[i] = toMotion(kept.segment<6>(k), Eigen::Vector3d::Zero(), result_.scene_radius) * start(i);
      most = std::max(most, (kept - moved).segment<6>(k).norm());
    }
    last_step_.resize(0);
    return most;
  }

  /** \brief Where a camera was to begin with, camera → scene's centre. */
  Eigen::Isometry3d start(std::size_t i) const { return Eigen::Translation3d(-result_.scene_center) * starts_[i]; }

  Eigen::Isometry3d correction(std::size_t i) const { return poses_[i] * start(i).inverse(); }

  /** \brief Moves all that hangs together with camera 0. */
  void fixGauge() {
    if (p_.gauge == Gauge::FirstCamera || poses_.empty()) return;
    takeMeanMotionAway(
        groupOfFirst(), [this](std::size_t i) { return correction(i); }, poses_);
  }

  std::vector<std::size_t> groupOfFirst() const {
    std::vector<bool> reached(system_.cameras(), false);
    reached[0] = true;
    for (bool grown = true; grown;) {
      grown = false;
      for (const PairSums& pair : system_.pairs())
        if (pair.geometry.count >= kFewest && reached[pair.i] != reached[pair.j])
          reached[pair.i] = reached[pair.j] = grown = true;
    }
    std::vector<std::size_t> group;
    for (std::size_t i = 0; i < reached.size(); ++i)
      if (reached[i]) group.push_back(i);
    return group;
  }

  void describe(const PoseGraph& graph) {
    const PoseUncertainty uncertainty(graph, system_, kFewest, 1.4826 * static_cast<double>(system_.medianResidual()));
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      CameraCorrection c;
      const Eigen::Translation3d center(result_.scene_center);
      if (poses_[i].matrix() != start(i).matrix()) c.T_correction = center * correction(i) * center.inverse();
      const Eigen::Vector3d place = poses_[i].translation();
      c.translation = (place - (initial_[i].translation() - result_.scene_center)).norm();
      c.rotation = Eigen::AngleAxisd(correction(i).linear()).angle();
      c.covariance = uncertainty.covariance(i);
      const Eigen::Vector3d lever = place / result_.scene_radius;
      Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
      J.leftCols<3>().setIdentity();
      J.rightCols<3>() << 0, lever.z(), -lever.y(), -lever.z(), 0, lever.x(), lever.y(), -lever.x(), 0;
      c.translation_deviation = std::sqrt((J * c.covariance * J.transpose()).trace());
      c.rotation_deviation = std::sqrt(c.covariance.bottomRightCorner<3, 3>().trace()) / result_.scene_radius;
      c.free_directions = graph.freeDirections(i);
      c.constrained = c.free_directions.empty();
      result_.corrections.push_back(c);
    }
    for (const CameraOverlap& overlap : result_.overlaps) {
      if (overlap.correspondences < static_cast<std::size_t>(kFewest)) continue;
      ++result_.corrections[overlap.first].neighbours;
      ++result_.corrections[overlap.second].neighbours;
    }
  }

  /** \brief Root mean squares with everything that max_correspondence_distance lets correspond, so that before and after compare. */
  void measure(double CameraOverlap::*residual, double& total) {
    system_.evaluate(
        poses_, result_.scene_radius,
        {p_.max_correspondence_distance, 0.0f, std::cos(p_.max_normal_angle), kNoLimit, 0.0f, kGreyLimit, false, 0, 1});
    AlignmentSums all{};
    const auto rms = [](const AlignmentSums& sums) { return sums.w > 0 ? std::sqrt(sums.wrr / sums.w) : 0.0; };
    for (CameraOverlap& overlap : result_.overlaps) overlap.correspondences = 0;
    for (const PairSums& pair : system_.pairs()) {
      const std::size_t first = std::min(pair.i, pair.j), second = std::max(pair.i, pair.j);
      auto overlap = std::find_if(result_.overlaps.begin(), result_.overlaps.end(),
                                  [&](const CameraOverlap& o) { return o.first == first && o.second == second; });
      if (overlap == result_.overlaps.end()) overlap = result_.overlaps.insert(overlap, {first, second, 0, 0.0, 0.0});
      const double both = static_cast<double>(overlap->correspondences) + pair.geometry.count;
      if (both > 0)
        (*overlap).*residual =
            std::sqrt((std::pow((*overlap).*residual, 2) * static_cast<double>(overlap->correspondences) +
                       std::pow(rms(pair.geometry), 2) * pair.geometry.count) /
                      both);
      overlap->correspondences = static_cast<std::size_t>(both);
      all += pair.geometry;
    }
    total = rms(all);
  }

  static constexpr float kNoLimit = 1e9f;
  static constexpr float kGreyLimit = 40.0f;         ///< of grey levels that may differ
  static constexpr float kDeviations = 3.0f;         ///< of noise, which the narrowest gate must not cut off
  static constexpr float kTukey = 4.685f;            ///< 95 % efficient on normal noise
  static constexpr float kNarrower = 0.65f;          ///< gate over that of the iteration before
  static constexpr double kFirstInformation = 1000;  ///< first what is observable best, then what is only beside it
  static constexpr double kMoreDaring = 0.3;         ///< information that suffices over that of the iteration before
  static constexpr std::size_t kHurry = 3;           ///< every so many-th sample until the gates are narrow
  static constexpr double kFewest = 30;              ///< correspondences of a pair
  static constexpr double kStill = 1e-4;             ///< metres; about what the choice of counterparts jitters
  static constexpr double kSettled = 1e-3;  ///< metres; then colours are near enough to compare, and scales are right
  static constexpr float kReach = 5.0f;     ///< gate over the last motion
  static constexpr double kEnoughForColor = 100;      ///< of information
  static constexpr double kMaxColorDeviation = 4e-3;  ///< metres at the scene's radius
  static constexpr double kScaleTolerance = 4;        ///< deviation over that of the next finer scale
  static constexpr int kScalePatience = 5;            ///< iterations; along weak motions colour is slow
  static constexpr int kPatience = 10;                ///< iterations; noisy data never converge
  static constexpr int kSecondLook = 6;               ///< iteration after which neighbours are known

  RigCorrespondences& system_;
  const ExtrinsicParameters& p_;
  const std::vector<Eigen::Isometry3d>& initial_;
  const std::vector<Eigen::Isometry3d> starts_;  ///< these, as rigid motions
  std::vector<Eigen::Isometry3d> poses_;         ///< camera → scene's centre
  Eigen::VectorXd last_step_;                    ///< none before the first
  ExtrinsicResult result_;
};

FUSE_FLOW_INLINE ExtrinsicResult alignRig(RigCorrespondences& rig, const ExtrinsicParameters& parameters,
                                          const std::vector<Eigen::Isometry3d>& initial) {
  return RigAlignment(rig, parameters, initial).run();
}

}  // namespace host
}  // namespace fuse_flow
