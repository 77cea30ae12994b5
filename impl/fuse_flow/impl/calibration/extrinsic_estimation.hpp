#pragma once

#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/impl/calibration/alignment_system.hpp>
#include <fuse_flow/impl/calibration/extrinsic_frames.hpp>
#include <fuse_flow/impl/calibration/rig_alignment.hpp>
#include <fuse_flow/impl/parameters.hpp>

namespace fuse_flow {

FUSE_FLOW_INLINE void checkParameters(const ExtrinsicParameters& p) {
  constexpr const char* owner = "fuse_flow::ExtrinsicEstimation";
  checkParameters(p.preprocessing);
  checkParameters(p.smoothing);
  detail::checkNoise(owner, p.noise);
  detail::checkRange(owner, "reduction", p.reduction, 1, 16);
  detail::checkNonNegative(owner, "coarse_above", p.coarse_above);
  detail::checkNonNegative(owner, "max_speckle", p.max_speckle);
  detail::checkRange(owner, "samples", p.samples, 100, 1 << 24);
  detail::checkRange(owner, "max_neighbours", p.max_neighbours, 1, 1 << 16);
  detail::checkLength(owner, "max_correspondence_distance", p.max_correspondence_distance);
  detail::checkPositive(owner, "min_correspondence_distance", p.min_correspondence_distance);
  detail::checkRange(owner, "min_correspondence_distance", p.min_correspondence_distance, 0.0f,
                     p.max_correspondence_distance);
  detail::checkRange(owner, "max_normal_angle", p.max_normal_angle, 0.01f, 1.57f);
  detail::checkRange(owner, "min_information", p.min_information, 1.0f, 1e12f);
  detail::checkNonNegative(owner, "residual_multipath", p.residual_multipath);
  detail::checkRange(owner, "max_iterations", p.max_iterations, 1, 1 << 20);
}

template <typename PointT>
ExtrinsicEstimation<PointT, device::Host>::ExtrinsicEstimation() : system_(std::make_unique<host::AlignmentSystem>()) {}

template <typename PointT>
ExtrinsicEstimation<PointT, device::Host>::~ExtrinsicEstimation() = default;

template <typename PointT>
void ExtrinsicEstimation<PointT, device::Host>::setParameters(const ExtrinsicParameters& parameters) {
  checkParameters(parameters);
  parameters_ = parameters;
}

template <typename PointT>
const ExtrinsicParameters& ExtrinsicEstimation<PointT, device::Host>::getParameters() const {
  return parameters_;
}

template <typename PointT>
void ExtrinsicEstimation<PointT, device::Host>::setNumberOfThreads(unsigned int threads) {
  threads_ = static_cast<int>(threads);
}

template <typename PointT>
void ExtrinsicEstimation<PointT, device::Host>::clear() {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::ExtrinsicEstimation");
  cameras_.clear();
  system_->clear();
}

template <typename PointT>
void ExtrinsicEstimation<PointT, device::Host>::addFrame(const RigFrame& frame) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::ExtrinsicEstimation");
  detail::takeCameras(frame, cameras_);
  system_->setThreads(host::resolveThreads(threads_));
  system_->add(frame, parameters_);
}

template <typename PointT>
void ExtrinsicEstimation<PointT, device::Host>::addClouds(const std::vector<Camera>& cameras,
                                                          const std::vector<PointCloudConstPtr>& clouds) {
  const detail::CloudFrame<PointT> frame(cameras, clouds);
  addFrame(frame.rig);
}

template <typename PointT>
ExtrinsicResult ExtrinsicEstimation<PointT, device::Host>::estimate() {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::ExtrinsicEstimation");
  return estimate(detail::posesOf(cameras_));
}

template <typename PointT>
ExtrinsicResult ExtrinsicEstimation<PointT, device::Host>::estimate(const std::vector<Eigen::Isometry3d>& initial) {
  const detail::OneThread::Inside inside(one_thread_, "fuse_flow::ExtrinsicEstimation");
  detail::checkInitialPoses(cameras_, system_->instants(), initial);
  system_->setThreads(host::resolveThreads(threads_));
  return host::alignRig(*system_, parameters_, initial);
}

}  // namespace fuse_flow
