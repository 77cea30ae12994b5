#pragma once

#include <fuse_flow/fuse_flow.h>
#include <fuse_flow/gpu/frames/frame_queue.h>

namespace fuse_flow {

/** \brief The frame pipeline on the GPU: same setters, same cells, the same points within float rounding as on the CPU, and
 *  the same bytes on every run. The points of a coarse cell are in the order of their places in it; the cells in the CPU's
 *  order.
 *
 *  \code
 *  fuse_flow::FuseFlow<fuse_flow::PointFused, fuse_flow::device::Thrust> fusion;
 *  fusion.fuse(frame, cloud);                         // one frame, from start to end
 *  fusion.submit(frame1); fusion.submit(frame2);      // or several at once: upload, computation and download overlap
 *  fusion.next(cloud);                                // the oldest
 *  \endcode
 *
 *  Images may be in pageable, pinned or device memory; each is found out by its pointer. Pinned memory is what makes an upload
 *  fast. Once warm, a frame allocates nothing. Only one thread at a time may use an object; a second thread gets a pcl::PCLException.
 *  Objects share nothing, so each thread may use its own object.
 *
 *  Compile with nvcc's -fmad=false (the CMake target does): a contracted multiply-add moves points across cell borders that
 *  the CPU does not. */
template <typename PointT>
class FuseFlow<PointT, device::Thrust> {
 public:
  using PointCloud = pcl::PointCloud<PointT>;
  using Ptr = std::shared_ptr<FuseFlow>;
  using ConstPtr = std::shared_ptr<const FuseFlow>;

  /** \brief Throws pcl::PCLException if there is no device. It runs on the device that is current where it is made. */
  FuseFlow() : lane_(std::make_unique<gpu::FrameLane<PointT>>()) {}

  /** \brief Throws pcl::BadArgumentException for a value out of range. */
  void setParameters(const FuseFlowParameters& parameters) {
    checkParameters(parameters);
    parameters_ = parameters;
  }
  const FuseFlowParameters& getParameters() const { return parameters_; }

  /** \brief Host threads that copy pageable images and clouds; 0, the default: one per core, at most 16, which keep memory busy. Frames in flight
   *  share them. */
  void setNumberOfThreads(unsigned int threads) { threads_ = static_cast<int>(threads); }

  /** \brief Fill PointT's normal, if it has one, from the depth images; default off. Clouds left on the device are then not called dense. */
  void setComputeNormals(bool compute) { compute_normals_ = compute; }

  /** \brief Write ω into PointT's intensity, if it has one, in place of the luminance; default off. */
  void setWeightInIntensity(bool weight) { weight_in_intensity_ = weight; }

  /** \brief The CUDA stream that fuse() and fuseOnDevice() run on; default the default stream. Frames in flight have streams
   *  of their own, on which each waits for what is on this one when it is submitted: so images on the device may still be
   *  being written by work on this stream, and a cloud that nextOnDevice() takes back still being read. */
  void setStream(gpu::Stream stream) { lane_->pipeline.run.stream = stream; }

  /** \brief How many frames submit() takes before next() must be called; 1 … 16, default 3. Each needs device memory of its
   *  own. Only while none is in flight. */
  void setFramesInFlight(std::size_t frames) {
    detail::checkRange("fuse_flow::FuseFlow", "frames in flight", frames, std::size_t{1}, std::size_t{16});
    if (inFlight() > 0)
      throw pcl::PCLException("fuse_flow::FuseFlow: frames are in flight: their number cannot change");
    frames_in_flight_ = frames;
    queue_.reset();
  }

  /** \brief Fuse one frame; as on the CPU. \throws pcl::PCLException also where the device's memory does not suffice */
  void fuse(const RigFrame& frame, PointCloud& output) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::FuseFlow");
    const gpu::HomeDevice::Visit visit(home_);
    prepare(*lane_);
    const gpu::PointSpan<PointT> points = lane_->fusePinned(frame);
    gpu::toCloud(points, frame.stamp, lane_->pipeline.threads, std::memcpy, output);
    statistics_ = lane_->pipeline.statistics;
  }

  /** \brief The same without a copy into a cloud: the points stay in pinned memory until the next call. */
  gpu::PointSpan<PointT> fusePinned(const RigFrame& frame) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::FuseFlow");
    const gpu::HomeDevice::Visit visit(home_);
    prepare(*lane_);
    const gpu::PointSpan<PointT> points = lane_->fusePinned(frame);
    statistics_ = lane_->pipeline.statistics;
    return points;
  }

  /** \brief The points left on the device, for what follows on the same stream; they stay until the next call. */
  gpu::PointSpan<PointT> fuseOnDevice(const RigFrame& frame) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::FuseFlow");
    const gpu::HomeDevice::Visit visit(home_);
    prepare(*lane_);
    const gpu::PointSpan<PointT> points = lane_->fuseOnDevice(frame);
    lane_->pipeline.finish();
    statistics_ = lane_->pipeline.statistics;
    return points;
  }

  /** \brief The same into a cloud of the caller's, for filters that follow on the same stream. */
  void fuse(const RigFrame& frame, gpu::DeviceCloud<PointT>& output) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::FuseFlow");
    const gpu::HomeDevice::Visit visit(home_);
    prepare(*lane_);
    lane_->fuseInto(frame, output);
    lane_->pipeline.finish();
    statistics_ = lane_->pipeline.statistics;
  }

  /** \brief Starts a frame and returns. Its images must stay alive until next() has returned it. \throws pcl::PCLException if
   *  as many frames are in flight as may be */
  void submit(const RigFrame& frame) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::FuseFlow");
    const gpu::HomeDevice::Visit visit(home_);
    if (!queue_) queue_ = std::make_unique<gpu::FrameQueue<PointT>>(frames_in_flight_);
    if (queue_->inFlight() == queue_->lanes())
      throw pcl::PCLException("fuse_flow::FuseFlow: " + std::to_string(queue_->lanes()) +
                              " frames are in flight; call next() first");
    const gpu::Delivery delivery = leave_on_device_ ? gpu::Delivery::Device
                                   : copy_ahead_    ? gpu::Delivery::Cloud
                                                    : gpu::Delivery::Pinned;
    queue_->submit(frame, delivery, lane_->pipeline.run.stream, [this](gpu::FrameLane<PointT>& lane) {
      prepare(lane);
      lane.pipeline.threads = gpu::copyThreads(threads_, queue_->lanes());
    });
  }

  /** \brief Frames submitted and not yet taken. */
  std::size_t inFlight() const { return queue_ ? queue_->inFlight() : 0; }

  /** \brief Whether each frame in flight is copied into a cloud by the thread that drives it, so that next() has only to swap;
   *  default on. Off for nextPinned(), which needs no cloud. Holds for what is submitted from then on. */
  void setCopyAhead(bool copy_ahead) { copy_ahead_ = copy_ahead; }

  /** \brief Whether frames in flight stay on the device, for nextOnDevice(); default off. next() and nextPinned() then download
   *  them. Holds for what is submitted from then on. */
  void setLeaveOnDevice(bool leave) { leave_on_device_ = leave; }

  /** \brief Waits for the oldest frame in flight. The memory of \p output goes to a later frame. Throws what fuse() would have
   *  thrown for it; that frame is then gone. \throws pcl::PCLException if none is in flight */
  void next(PointCloud& output) {
    take([&](const gpu::PointSpan<PointT>& points, std::uint64_t stamp, PointCloud* copied) {
      if (copied) {
        output.swap(*copied);
      } else {
        gpu::toCloud(points, stamp, gpu::copyThreads(threads_), std::memcpy, output);
      }
    });
  }

  /** \brief The same without a copy: visit(points in pinned memory, stamp). */
  template <typename Visit>
  void nextPinned(const Visit& visit) {
    take([&](const gpu::PointSpan<PointT>& points, std::uint64_t stamp, PointCloud*) { visit(points, stamp); });
  }

  /** \brief The same into a cloud on the device, complete when this returns: any stream may read it. The memory of \p output goes
   *  to a later frame, which waits for what is on the stream of setStream() when it is submitted. */
  void nextOnDevice(gpu::DeviceCloud<PointT>& output) {
    takeLane([&](gpu::FrameLane<PointT>& lane, const gpu::PointSpan<PointT>&, std::uint64_t, PointCloud*) {
      lane.swapOutput(output);
    });
  }

  const FrameStatistics& getStatistics() const { return statistics_; }

  /** \brief Device memory that fuse() holds, bytes. */
  std::size_t getDeviceBytes() const { return lane_->bytes(); }

  /** \brief Frames of fuse() whose first half was launched as a CUDA graph; 0 on the default stream, which cannot be captured. */
  std::size_t getGraphReplays() const { return lane_->pipeline.graphReplays(); }

  /** \brief Measure the stages of fuse(); default off. */
  gpu::StageTimes& stageTimes() { return lane_->pipeline.times; }

 private:
  template <typename Take>
  void takeLane(const Take& visit) {
    const detail::OneThread::Inside inside(one_thread_, "fuse_flow::FuseFlow");
    if (inFlight() == 0) throw pcl::PCLException("fuse_flow::FuseFlow: no frame is in flight");
    const gpu::HomeDevice::Visit at_home(home_);
    queue_->next([&](gpu::FrameLane<PointT>& lane, const gpu::PointSpan<PointT>& points, std::uint64_t stamp,
                     PointCloud* copied) {
      statistics_ = lane.pipeline.statistics;
      visit(lane, points, stamp, copied);
    });
  }

  /** \brief In host memory. */
  template <typename Take>
  void take(const Take& visit) {
    takeLane([&](gpu::FrameLane<PointT>& lane, const gpu::PointSpan<PointT>& points, std::uint64_t stamp,
                 PointCloud* copied) { visit(points.points != nullptr ? points : lane.download(), stamp, copied); });
  }

  void prepare(gpu::FrameLane<PointT>& lane) {
    lane.pipeline.parameters = parameters_;
    lane.pipeline.threads = gpu::copyThreads(threads_);
    lane.compute_normals = compute_normals_;
    lane.weight_in_intensity = weight_in_intensity_;
  }

  gpu::HomeDevice home_{"fuse_flow::FuseFlow"};  // first: nothing else is made without a device
  detail::OneThread one_thread_;
  FuseFlowParameters parameters_;
  int threads_{0};
  bool compute_normals_{false};
  bool weight_in_intensity_{false};
  bool copy_ahead_{true};
  bool leave_on_device_{false};
  std::size_t frames_in_flight_{3};
  std::unique_ptr<gpu::FrameLane<PointT>> lane_;
  std::unique_ptr<gpu::FrameQueue<PointT>> queue_;
  FrameStatistics statistics_;
};

}  // namespace fuse_flow
