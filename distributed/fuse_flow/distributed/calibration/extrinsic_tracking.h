#pragma once

#include <fuse_flow/calibration/extrinsic_tracking.h>
#include <fuse_flow/distributed/calibration/extrinsic_estimation.h>

#include <pcl/point_types.h>

#include <algorithm>
#include <chrono>
#include <optional>

namespace fuse_flow {
namespace distributed {

/** \brief Keeps the poses of a rig right while it runs, where each rank has the views of some of the cameras. The poses are those that
 *  ExtrinsicTracking gives in one process to which finish() is called after each push(). On the CPU.
 *
 *  Unlike there, push() returns only once the poses are found: messages of the search and of the frame would get mixed up otherwise. So
 *  setMinInterval() says how much of the time the search may take.
 *
 *  All ranks call push() for the same frames. Only one thread at a time may use an object. */
class ExtrinsicTracking {
 public:
  /** \param communicator of this rank; must outlive this object  \param cameras with the initial poses; the same at all ranks  \param deviation of these
   *  poses, metres at the scene's radius; those of rank 0 count, and so does \p filter
   *  \throws pcl::BadArgumentException for a camera that contradicts itself or a parameter out of range */
  ExtrinsicTracking(
      Communicator& communicator, const std::vector<Camera>& cameras, double deviation = 0.02,
      const ExtrinsicParameters& parameters = fuse_flow::ExtrinsicTracking<pcl::PointXYZ>::defaultParameters(),
      const PoseFilterParameters& filter = {})
      : communicator_(&communicator), estimation_(communicator) {
    for (const Camera& camera : cameras) checkCamera(camera);
    poses_.T_world_camera = detail::posesOf(cameras);
    estimation_.setParameters(parameters);
    filter_.setParameters(filter);
    filter_.reset(poses_.T_world_camera, deviation);
  }

  /** \brief Threads of this rank; 0, the default, is one per core. */
  void setNumberOfThreads(unsigned int threads) { estimation_.setNumberOfThreads(threads); }

  /** \brief Shortest time between two accepted frames, by their stamps, microseconds; ≥ 0. That of rank 0 counts. The default, 30 ms, accepts every
   *  frame of cameras at 30 Hz. */
  void setMinInterval(std::uint64_t microseconds) { min_interval_ = microseconds; }
  /** \brief As set. */
  std::uint64_t getMinInterval() const { return min_interval_; }

  /** \brief Offers a frame; every rank calls this. \param frame with all cameras, and the views of those that this rank has
   *  \returns whether it was accepted: not within the minimum interval after the last one, and not of a rig of one camera
   *  \throws what ExtrinsicEstimation::estimate() throws */
  bool push(const RigFrame& frame) {
    const auto start = std::chrono::steady_clock::now();
    if (!accepts(frame)) return false;
    estimation_.clear();
    estimation_.addFrame(frame);
    const ExtrinsicResult result = estimation_.estimate(filter_.poses());
    if (communicator_->rank() == 0) {
      poses_.moved = filter_.update(result);
      poses_.T_world_camera = filter_.poses();
      poses_.stamp = frame.stamp;
      ++poses_.updates;
      poses_.milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    }
    share([&](MessageWriter& out) { PoseMessages::put(out, poses_); },
          [&](MessageReader& in) { poses_ = PoseMessages::getTracked(in, frame.cameras.size()); });
    return true;
  }

  /** \brief The newest poses; the same at all ranks. */
  const TrackedPoses& poses() const { return poses_; }
  /** \brief Writes the newest poses into a frame's cameras. */
  void apply(RigFrame& frame) const {
    for (std::size_t i = 0; i < std::min(poses_.T_world_camera.size(), frame.cameras.size()); ++i)
      frame.cameras[i].T_world_camera = poses_.T_world_camera[i];
  }

 private:
  /** \brief What rank 0 decides by its stamps. */
  bool accepts(const RigFrame& frame) {
    std::uint8_t accepted = 0;
    if (communicator_->rank() == 0) {
      // A recording that begins anew goes back in time.
      const bool too_soon = last_stamp_ && frame.stamp > *last_stamp_ && frame.stamp - *last_stamp_ < min_interval_;
      accepted = !too_soon && frame.cameras.size() >= 2 ? 1 : 0;
      if (accepted != 0) last_stamp_ = frame.stamp;
    }
    share([&](MessageWriter& out) { out.put(accepted); },
          [&](MessageReader& in) { accepted = in.get<std::uint8_t>(); });
    return accepted != 0;
  }

  /** \brief From rank 0 to all others. */
  template <typename Write, typename Read>
  void share(const Write& write, const Read& read) {
    if (communicator_->rank() == 0) {
      Message message;
      MessageWriter writer(message);
      write(writer);
      sendToOthers(*communicator_, message);
    } else {
      std::vector<Message> in;
      communicator_->exchange({}, {0}, in);
      MessageReader reader(in[0], 0);
      read(reader);
      reader.finish();
    }
  }

  Communicator* communicator_;
  ExtrinsicEstimation estimation_;
  PoseFilter filter_;
  TrackedPoses poses_;
  std::uint64_t min_interval_{30000};
  std::optional<std::uint64_t> last_stamp_;  ///< of the last accepted frame
};

}  // namespace distributed
}  // namespace fuse_flow
