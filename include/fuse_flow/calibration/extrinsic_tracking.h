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

/** \brief The poses of a rig at one time; all of one estimate. */
struct TrackedPoses {
  std::vector<Eigen::Isometry3d> T_world_camera;  ///< camera by camera
  std::uint64_t stamp{0};                         ///< of the frame that they come from, microseconds
  std::size_t updates{0};                         ///< estimates so far
  std::vector<CameraMotion> moved;                ///< cameras that this estimate confirmed to have moved
  double milliseconds{0};                         ///< that the estimate took
};

/** \brief Keeps the poses of a rig right while it runs, on a thread of its own beside FuseFlow, which stays without state;
 *  on Linux the thread gives way to others (nice 5 behind its maker).
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
 *  Any number of threads may call push(), finish(), poses() and apply() of one object, each with frames of its own; set up by one. Objects share nothing.
 *
 *  With device::Thrust, of fuse_flow/gpu/calibration/extrinsic_tracking.h, the GPU does the work, on a stream of its own. */
template <typename PointT, typename Device = device::Host>
class ExtrinsicTracking {
 public:
  /** \brief What a frame of a running rig is estimated with: fewer points and iterations than from scratch. */
  static ExtrinsicParameters defaultParameters();

  /** \brief Starts the thread. \param cameras with the poses to begin at  \param deviation of those poses, metres at the
   *  scene's radius  \param parameters of the estimate; the first camera's pose is not held  \param filter of the filter
   *  \throws pcl::BadArgumentException for a camera that contradicts itself or a parameter out of range */
  explicit ExtrinsicTracking(const std::vector<Camera>& cameras, double deviation = 0.02,
                             const ExtrinsicParameters& parameters = defaultParameters(),
                             const PoseFilterParameters& filter = {});
  /** \brief Waits for the estimate that is under way. */
  ~ExtrinsicTracking();
  ExtrinsicTracking(const ExtrinsicTracking&) = delete;
  ExtrinsicTracking& operator=(const ExtrinsicTracking&) = delete;

  /** \brief Threads for an estimate; 1, the default, leaves the others to the fusion. */
  void setNumberOfThreads(unsigned int threads);

  /** \brief How long after a frame that was taken another one may be, by their stamps, microseconds; ≥ 0. The default, 30 ms, takes every
   *  frame of cameras at 30 Hz and leaves what is faster to the fusion: poses change more slowly. 0: takes all. */
  void setMinInterval(std::uint64_t microseconds);
  /** \brief As set. */
  std::uint64_t getMinInterval() const;

  /** \brief Offers a frame, whose images are in host memory. From any thread; never waits. \returns whether it was taken: not while another is being copied or worked
   *  on, not sooner than the least interval after the last one (frames with its very stamp, such as 0, are not told apart, and are taken), and not of one camera alone, of which nothing can be told
   *  \throws pcl::BadArgumentException if the frame contradicts itself or has other cameras; what an estimate threw meanwhile */
  bool push(const RigFrame& frame);

  /** \brief Waits until the frame that was taken last is done. */
  void finish();

  /** \brief The newest poses. */
  std::shared_ptr<const TrackedPoses> poses() const;
  /** \brief Puts the newest poses into a frame's cameras. */
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
  bool copying_{false};  ///< somebody writes to copy_
  bool taken_{false};    ///< copy_ is the thread's
  bool stop_{false};
  std::uint64_t min_interval_{30000};
  std::optional<std::uint64_t> last_stamp_;  ///< of the frame taken last
  std::exception_ptr error_;
  std::shared_ptr<const TrackedPoses> poses_;
  std::thread thread_;
};

}  // namespace fuse_flow

#ifndef FUSE_FLOW_DECLARATIONS_ONLY
#include <fuse_flow/impl/calibration/extrinsic_tracking.hpp>
#endif
