#pragma once

#include <fuse_flow/calibration/depth_correction_estimation.h>
#include <fuse_flow/impl/calibration/correction_search.hpp>
#include <fuse_flow/impl/calibration/extrinsic_estimation.hpp>

namespace fuse_flow {

FUSE_FLOW_INLINE void checkParameters(const DepthCorrectionParameters& p) {
  constexpr const char* owner = "fuse_flow::DepthCorrectionEstimation";
  checkParameters(p.views);
  detail::checkRange(owner, "columns", p.columns, 2, 64);
  detail::checkRange(owner, "rows", p.rows, 2, 64);
  detail::checkPositive(owner, "magnitude", p.magnitude);
  detail::checkPositive(owner, "roughness", p.roughness);
  detail::checkPositive(owner, "pose_deviation", p.pose_deviation);
  detail::checkRange(owner, "redundancy", p.redundancy, 1.0f, 1e6f);
  detail::checkRange(owner, "effective_instants", p.effective_instants, 1, 1000000);
}

FUSE_FLOW_INLINE DepthCorrectionEstimation::DepthCorrectionEstimation()
    : system_(std::make_unique<host::AlignmentSystem>()) {}
FUSE_FLOW_INLINE DepthCorrectionEstimation::~DepthCorrectionEstimation() = default;

FUSE_FLOW_INLINE void DepthCorrectionEstimation::setParameters(const DepthCorrectionParameters& parameters) {
  checkParameters(parameters);
  parameters_ = parameters;
}

FUSE_FLOW_INLINE void DepthCorrectionEstimation::clear() {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::DepthCorrectionEstimation");
  cameras_.clear();
  system_->clear();
}

FUSE_FLOW_INLINE void DepthCorrectionEstimation::addFrame(const RigFrame& frame) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::DepthCorrectionEstimation");
  RigFrame raw = frame;
  for (Camera& camera : raw.cameras) camera.depth_correction = {};
  detail::takeCameras(raw, cameras_);
  ExtrinsicParameters views = parameters_.views;
  views.use_color = false;
  system_->setThreads(host::resolveThreads(threads_));
  system_->add(raw, views);
}

FUSE_FLOW_INLINE DepthCorrectionResult DepthCorrectionEstimation::estimate() {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::DepthCorrectionEstimation");
  return estimate(detail::posesOf(cameras_));
}

FUSE_FLOW_INLINE DepthCorrectionResult
DepthCorrectionEstimation::estimate(const std::vector<Eigen::Isometry3d>& initial) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::DepthCorrectionEstimation");
  detail::checkInitialPoses(cameras_, system_->instants(), initial);
  system_->setThreads(host::resolveThreads(threads_));
  return host::CorrectionSearch(*system_, parameters_, cameras_, initial, host::resolveThreads(threads_)).run();
}

FUSE_FLOW_INLINE DepthCorrectionResult DepthCorrectionEstimation::estimate(
    const std::vector<Eigen::Isometry3d>& initial, const std::vector<Eigen::Isometry3d>& refined) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::DepthCorrectionEstimation");
  detail::checkInitialPoses(cameras_, system_->instants(), initial);
  detail::checkInitialPoses(cameras_, system_->instants(), refined);
  system_->setThreads(host::resolveThreads(threads_));
  return host::CorrectionSearch(*system_, parameters_, cameras_, initial, host::resolveThreads(threads_)).run(&refined);
}

}  // namespace fuse_flow
