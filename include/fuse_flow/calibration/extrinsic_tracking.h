#pragma once

#include <fuse_flow/calibration/extrinsic_estimation.h>
#include <fuse_flow/calibration/pose_filter.h>
#include <fuse_flow/precompiled.h>

#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace fuse_flow {

/** \brief The poses of a rig at one time; all come from one estimate. */
struct TrackedPoses {
  std::vector<Eigen::Isometry3d> T_world_camera;  ///< camera by camera
  std::uint64_t stamp{0};                         ///< of the frame that they come from, microseconds
  std::size_t updates{0};                         ///< estimates so far
  std::vector<CameraMotion> moved;                ///< cameras that this estimate confirmed to have moved
  double milliseconds{0};                         ///< duration of the estimate
};

/** \brief Keeps the poses of a rig right while the rig runs. It works in its own thread, in parallel with FuseFlow, which keeps no state.
 *  On Linux, the thread has a lower priority: its nice value is 5 above that of its creator.
 *
 *  \code
 *  fuse_flow::ExtrinsicTracking<pcl::PointXYZRGB> tracking(frame.cameras);
 *  while (nextFrame(frame)) {
 *    tracking.push(frame);   // copies the images if the thread is idle, else does nothing
 *    tracking.apply(frame);  // the newest complete set of poses
 *    fusion.fuse(frame, cloud);
 *  }
 *  \endcode
 *
 *  Any number of threads may call push(), finish(), poses() and apply() of one object, each with its own frames. Only one thread may call
 *  the setters. Objects share nothing.
 *
 *  With device::Thrust, from fuse_flow/gpu/calibration/extrinsic_tracking.h, the GPU does the work, on its own stream. */
template <typename PointT, typename Device = device::Host>
class ExtrinsicTracking {
 public:
  /** \brief The parameters for a frame of a running rig: fewer points and iterations than the defaults. */
  static ExtrinsicParameters defaultParameters();

  /** \brief Starts the thread. \param cameras with the initial poses \param deviation standard deviation of these poses, metres at the
   *  scene's radius \param parameters of the estimate; the first camera's pose is not fixed \param filter parameters of the filter
   *  \throws pcl::BadArgumentException for a camera that contradicts itself or a parameter out of range */
  explicit ExtrinsicTracking(const std::vector<Camera>& cameras, double deviation = 0.02,
                             const ExtrinsicParameters& parameters = defaultParameters(),
                             const PoseFilterParameters& filter = {});
  /** \brief Waits for the current estimate. */
  ~ExtrinsicTracking();
  ExtrinsicTracking(const ExtrinsicTracking&) = delete;
  ExtrinsicTracking& operator=(const ExtrinsicTracking&) = delete;

  /** \brief Number of threads for an estimate; the default, 1, leaves the other cores to the fusion. */
  void setNumberOfThreads(unsigned int threads);

  /** \brief Shortest time between two accepted frames, by their stamps, microseconds; ≥ 0. The default, 30 ms, accepts every frame of
   *  cameras at 30 Hz. Faster frames are skipped, because poses change slowly. 0 accepts all frames. */
  void setMinInterval(std::uint64_t microseconds);
  /** \brief As set. */
  std::uint64_t getMinInterval() const;

  /** \brief Offers a frame, whose images are in host memory. May be called from any thread; never waits. \returns whether the frame was
   *  accepted. It is not accepted while another frame is copied or processed, nor within the minimum interval after the last accepted frame
   *  (a frame with the same stamp, such as 0, is accepted), nor if only one camera has a view, because nothing can be estimated then
   *  \throws pcl::BadArgumentException if the frame contradicts itself or has other cameras; also rethrows an exception of an earlier
   *  estimate */
  bool push(const RigFrame& frame);

  /** \brief Waits until the last accepted frame is processed. */
  void finish();

  /** \brief The newest poses. */
  std::shared_ptr<const TrackedPoses> poses() const;
  /** \brief Writes the newest poses into a frame's cameras. */
  void apply(RigFrame& frame) const;

 private:
  /** \brief The images of a frame, owned. */
  struct Copy {
    RigFrame frame;
    std::vector<std::vector<std::uint16_t>> depth16;
    std::vector<std::vector<float>> depth32;
    std::vector<std::vector<Rgb8>> color;
    void assign(const RigFrame& from, bool with_color);
  };

  void work();
  void estimate();

  ExtrinsicParameters parameters_;
  std::size_t cameras_;
  ExtrinsicEstimation<PointT, Device> estimation_;
  PoseFilter filter_;
  Copy copy_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool copying_{false};  ///< a thread writes to copy_
  bool taken_{false};    ///< the estimating thread reads copy_
  bool stop_{false};
  std::uint64_t min_interval_{30000};
  std::optional<std::uint64_t> last_stamp_;  ///< of the last accepted frame
  std::exception_ptr error_;
  std::shared_ptr<const TrackedPoses> poses_;
  std::thread thread_;
};

}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY
#include <fuse_flow/impl/calibration/extrinsic_tracking.hpp>
#endif
