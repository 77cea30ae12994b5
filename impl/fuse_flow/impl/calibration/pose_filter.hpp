#pragma once

#include <fuse_flow/calibration/pose_filter.h>
#include <fuse_flow/impl/calibration/dense_algebra.hpp>
#include <fuse_flow/impl/calibration/twist.hpp>
#include <fuse_flow/impl/parameters.hpp>

#include <algorithm>

namespace fuse_flow {

FUSE_FLOW_INLINE void checkParameters(const PoseFilterParameters& p) {
  constexpr const char* owner = "fuse_flow::PoseFilter";
  detail::checkNonNegative(owner, "drift", p.drift);
  detail::checkPositive(owner, "deviation_scale", p.deviation_scale);
  detail::checkPositive(owner, "min_deviation", p.min_deviation);
  detail::checkPositive(owner, "gate", p.gate);
  detail::checkRange(owner, "confirmations", p.confirmations, 2, 1 << 20);
}

FUSE_FLOW_INLINE void PoseFilter::setParameters(const PoseFilterParameters& parameters) {
  checkParameters(parameters);
  parameters_ = parameters;
}

FUSE_FLOW_INLINE void PoseFilter::reset(const std::vector<Eigen::Isometry3d>& poses, double deviation) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::PoseFilter");
  detail::checkPositive("fuse_flow::PoseFilter", "deviation", static_cast<float>(deviation));
  poses_ = poses;
  State state;
  state.P = deviation * deviation * Covariance::Identity();
  states_.assign(poses.size(), state);
}

FUSE_FLOW_INLINE double PoseFilter::deviation(std::size_t camera) const {
  return std::sqrt(states_[camera].P.trace() / 6);
}

FUSE_FLOW_INLINE PoseFilter::Covariance PoseFilter::noise(const CameraCorrection& correction) const {
  const double scale = parameters_.deviation_scale, least = parameters_.min_deviation;
  return scale * scale * correction.covariance + least * least * Covariance::Identity();
}

FUSE_FLOW_INLINE std::vector<CameraMotion> PoseFilter::update(const ExtrinsicResult& estimate) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::PoseFilter");
  const std::size_t n = poses_.size();
  if (estimate.corrections.size() != n || estimate.T_world_camera.size() != n)
    detail::throwBadArgument("fuse_flow::PoseFilter: an estimate of ", estimate.corrections.size(), " cameras for ", n);
  const Eigen::Vector3d& center = estimate.scene_center;
  const double radius = estimate.scene_radius;
  std::vector<Twist> twists(n);
  for (std::size_t i = 0; i < n; ++i)
    twists[i] = host::toTwist(estimate.T_world_camera[i] * poses_[i].inverse(), center, radius);
  const std::size_t held = reference(twists, estimate);
  const Eigen::Isometry3d common = estimate.T_world_camera[held] * poses_[held].inverse();

  std::vector<CameraMotion> moved;
  for (std::size_t i = 0; i < n; ++i) {
    if (estimate.corrections[i].neighbours == 0) continue;  // it said nothing of this camera
    State& state = states_[i];
    const Eigen::Isometry3d found = common.inverse() * estimate.T_world_camera[i];
    const Twist innovation = host::toTwist(found * poses_[i].inverse(), center, radius);
    const Covariance R = noise(estimate.corrections[i]);
    state.P += static_cast<double>(parameters_.drift) * parameters_.drift * Covariance::Identity();
    const host::CholeskyFactors S(state.P + R);
    if (host::squaredMahalanobis(innovation, S) <= parameters_.gate) {
      const Covariance gain = S.solveColumns(state.P).transpose();
      poses_[i] = host::toMotion(gain * innovation, center, radius) * poses_[i];
      state.P = (Covariance::Identity() - gain) * state.P;
      state.P = 0.5 * (state.P + state.P.transpose().eval());
      state.odd = 0;
      continue;
    }
    const Twist since = host::toTwist(found * state.odd_pose.inverse(), center, radius);
    const bool agrees =
        state.odd > 0 && host::squaredMahalanobis(since, host::CholeskyFactors(2 * R)) <= parameters_.gate;
    state.odd = agrees ? state.odd + 1 : 1;
    state.odd_pose = found;
    if (state.odd < parameters_.confirmations) continue;
    CameraMotion motion;
    motion.camera = i;
    motion.T_new_old = found * poses_[i].inverse();
    motion.translation = (found.translation() - poses_[i].translation()).norm();
    motion.rotation = Eigen::AngleAxisd(motion.T_new_old.linear()).angle();
    moved.push_back(motion);
    poses_[i] = found;
    state.P = R;
    state.odd = 0;
  }
  return moved;
}

/** \brief The camera beside which most others stay where they were. */
FUSE_FLOW_INLINE std::size_t PoseFilter::reference(const std::vector<Twist>& twists,
                                                   const ExtrinsicResult& estimate) const {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::max();
  for (std::size_t k = 0; k < twists.size(); ++k) {
    if (estimate.corrections[k].neighbours == 0) continue;
    double sum = 0;
    for (std::size_t i = 0; i < twists.size(); ++i) {
      if (estimate.corrections[i].neighbours == 0) continue;
      const Twist apart = twists[i] - twists[k];
      const Covariance S =
          states_[i].P + states_[k].P + noise(estimate.corrections[i]) + noise(estimate.corrections[k]);
      sum += std::min(static_cast<double>(parameters_.gate), host::squaredMahalanobis(apart, host::CholeskyFactors(S)));
    }
    if (sum < 0.999 * least) {  // of equals the first
      least = sum;
      best = k;
    }
  }
  return best;
}

}  // namespace fuse_flow
