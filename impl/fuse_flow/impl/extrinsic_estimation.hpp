#pragma once

#include <fuse_flow/extrinsic_estimation.h>
#include <fuse_flow/impl/host/alignment_system.hpp>
#include <fuse_flow/impl/host/pose_graph.hpp>
#include <fuse_flow/impl/host/rig_alignment.hpp>
#include <fuse_flow/impl/parameters.hpp>

#include <pcl/exceptions.h>

namespace fuse_flow {

FUSE_FLOW_INLINE void checkParameters(const ExtrinsicParameters& p) {
  constexpr const char* owner = "fuse_flow::ExtrinsicEstimation";
  checkParameters(p.preprocessing);
  checkParameters(p.smoothing);
  checkParameters(p.noise);
  detail::checkRange(owner, "reduction", p.reduction, 1, 16);
  detail::checkRange(owner, "samples", p.samples, 100, 1 << 24);
  detail::checkRange(owner, "max_neighbours", p.max_neighbours, 1, 1 << 16);
  detail::checkPositive(owner, "max_distance", p.max_distance);
  detail::checkPositive(owner, "min_distance", p.min_distance);
  detail::checkRange(owner, "min_distance", p.min_distance, 0.0f, p.max_distance);
  detail::checkRange(owner, "max_normal_angle", p.max_normal_angle, 0.01f, 1.57f);
  detail::checkRange(owner, "min_information", p.min_information, 1.0f, 1e12f);
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
  cameras_.clear();
  system_->clear();
}

template <typename PointT>
void ExtrinsicEstimation<PointT, device::Host>::addFrame(const RigFrame& frame) {
  checkRigFrame(frame);
  if (cameras_.empty()) {
    cameras_ = frame.cameras;
  } else if (cameras_.size() != frame.cameras.size()) {
    detail::throwBadArgument("fuse_flow::ExtrinsicEstimation: a frame of ", frame.cameras.size(),
                             " cameras after one of ", cameras_.size());
  }
  system_->setThreads(host::resolveThreads(threads_));
  system_->add(frame, parameters_);
}

template <typename PointT>
void ExtrinsicEstimation<PointT, device::Host>::addClouds(const std::vector<Camera>& cameras,
                                                          const std::vector<PointCloudConstPtr>& clouds) {
  if (cameras.size() != clouds.size())
    detail::throwBadArgument("fuse_flow::ExtrinsicEstimation: ", cameras.size(), " cameras but ", clouds.size(),
                             " clouds");
  RigFrame frame;
  frame.cameras = cameras;
  frame.views.resize(cameras.size());
  std::vector<std::vector<float>> depths(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (!clouds[i]) continue;
    for (const PointT& point : *clouds[i]) depths[i].push_back(point.z);
    frame.views[i].depth32 = {depths[i].data(), static_cast<int>(clouds[i]->width),
                              static_cast<int>(clouds[i]->height)};
  }
  addFrame(frame);
}

template <typename PointT>
ExtrinsicResult ExtrinsicEstimation<PointT, device::Host>::estimate() {
  std::vector<Eigen::Isometry3d> initial;
  for (const Camera& camera : cameras_) initial.push_back(camera.T_world_camera);
  return estimate(initial);
}

template <typename PointT>
ExtrinsicResult ExtrinsicEstimation<PointT, device::Host>::estimate(const std::vector<Eigen::Isometry3d>& initial) {
  if (system_->instants() == 0) throw pcl::PCLException("fuse_flow::ExtrinsicEstimation: no frame was added");
  if (initial.size() != cameras_.size())
    detail::throwBadArgument("fuse_flow::ExtrinsicEstimation: ", initial.size(), " poses for ", cameras_.size(),
                             " cameras");
  for (std::size_t i = 0; i < initial.size(); ++i)
    detail::checkPose({"fuse_flow::ExtrinsicEstimation: camera '", cameras_[i].name, "'"}, "initial pose", initial[i]);
  system_->setThreads(host::resolveThreads(threads_));
  return host::RigAlignment(*system_, parameters_, initial).run();
}

}  // namespace fuse_flow
