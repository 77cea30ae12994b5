#pragma once

#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/gpu/calibration/alignment_system.h>
#include <fuse_flow/gpu/runtime/on_error.h>
#include <fuse_flow/impl/calibration/extrinsic_frames.hpp>

namespace fuse_flow {

/** \brief On the GPU: same setters, the same samples, neighbours and equations as on the CPU, and the same bytes on every run. The
 *  images and all that is made of them stay on the device; what comes back are sums over pairs of cameras, some ten kilobytes an
 *  iteration. The small dense algebra behind them is the host's: see fuse_flow/precompiled.h, which has a compiler other than
 *  nvcc compile it, whose code for it is faster.
 *
 *  Images may be in pageable, pinned or device memory; each is found out by its pointer. Once warm, an estimate allocates no device
 *  memory. Objects are independent: one a thread.
 *
 *  Compile with nvcc's -fmad=false (the CMake target does). */
template <typename PointT>
class ExtrinsicEstimation<PointT, device::Thrust> {
 public:
  ///@{
  /** \brief As in PCL's classes. */
  using PointCloud = pcl::PointCloud<PointT>;
  using PointCloudConstPtr = typename PointCloud::ConstPtr;
  using Ptr = std::shared_ptr<ExtrinsicEstimation>;
  using ConstPtr = std::shared_ptr<const ExtrinsicEstimation>;
  ///@}

  /** \brief Throws pcl::PCLException if there is no device. It runs on the device that is current where it is made. */
  ExtrinsicEstimation() : system_(std::make_unique<gpu::AlignmentSystem>()) {}

  /** \brief Throws pcl::BadArgumentException for a value out of range. */
  void setParameters(const ExtrinsicParameters& parameters) {
    checkParameters(parameters);
    parameters_ = parameters;
  }
  /** \brief What setParameters() set, or the defaults. */
  const ExtrinsicParameters& getParameters() const { return parameters_; }

  /** \brief Host threads that copy pageable images; 0: one per core, at most 16, which keep memory busy. */
  void setNumberOfThreads(unsigned int threads) { system_->threads = gpu::copyThreads(static_cast<int>(threads)); }

  /** \brief The CUDA stream that it runs on; default the default stream. */
  void setStream(gpu::Stream stream) { system_->run.stream = stream; }

  /** \brief Forget all frames; their memory stays for those to come. */
  void clear() {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::ExtrinsicEstimation");
    cameras_.clear();
    system_->clear();
  }

  /** \brief One instant more; what is needed of it is copied. The poses of the first frame are where the search begins.
   *  \throws pcl::BadArgumentException as on the CPU  \throws pcl::PCLException also where the device's memory does not
   *  suffice */
  void addFrame(const RigFrame& frame) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::ExtrinsicEstimation");
    const gpu::HomeDevice::Visit visit(home_);
    const gpu::OnError settle([this] { system_->run.settle(); });
    detail::takeCameras(frame, cameras_);
    system_->add(frame, parameters_);
  }

  /** \brief The same from organised clouds in host memory, each in its camera's frame (z forward); null: missing.
   *  \throws pcl::BadArgumentException if a cloud does not have its camera's size */
  void addClouds(const std::vector<Camera>& cameras, const std::vector<PointCloudConstPtr>& clouds) {
    const detail::CloudFrame<PointT> frame(cameras, clouds);
    addFrame(frame.rig);
  }

  /** \brief From the poses that addFrame() was given. \throws pcl::PCLException without a frame */
  ExtrinsicResult estimate() { return estimate(detail::posesOf(cameras_)); }

  /** \brief From other poses, one a camera. */
  ExtrinsicResult estimate(const std::vector<Eigen::Isometry3d>& initial) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::ExtrinsicEstimation");
    const gpu::HomeDevice::Visit visit(home_);
    detail::checkInitialPoses(cameras_, system_->instants(), initial);
    const gpu::OnError settle([this] { system_->run.settle(); });
    system_->spent = {};
    return host::alignRig(*system_, parameters_, initial);
  }

  /** \brief Device memory held, bytes. */
  std::size_t getDeviceBytes() const { return system_->bytes(); }

  /** \brief Measure the stages of addFrame(); default off. */
  gpu::StageTimes& stageTimes() { return system_->times; }
  /** \brief Of the last estimate(). */
  const gpu::EstimateTimes& getEstimateTimes() const { return system_->spent; }

  /** \brief Give it a stream of its own, which does not wait for the default one. */
  void useOwnStream() {
    const gpu::HomeDevice::Visit visit(home_);
    own_stream_ = std::make_unique<gpu::OwnStream>();
    setStream(own_stream_->get());
  }

 private:
  gpu::HomeDevice home_{"fuse_flow::ExtrinsicEstimation"};  // first: nothing else is made without a device
  detail::OneThread one_thread_;
  ExtrinsicParameters parameters_;
  std::vector<Camera> cameras_;
  std::unique_ptr<gpu::OwnStream> own_stream_;  // outlives what runs on it
  std::unique_ptr<gpu::AlignmentSystem> system_;
};

/** \brief See ExtrinsicTracking. */
template <typename PointT>
void runBesideOthers(ExtrinsicEstimation<PointT, device::Thrust>& estimation) {
  estimation.useOwnStream();
}

}  // namespace fuse_flow
