#pragma once

#include "calibration/poses.h"

#include <fuse_flow/calibration/pose_filter.h>

#include <functional>
#include <utility>

namespace fuse_flow::io {

/** \brief Who searches for poses on a device: makePoseEstimation() and makePoseTracking(), or a test's. */
struct PoseMakers {
  std::function<std::unique_ptr<PoseEstimation>(const std::string& device, const ExtrinsicParameters&)> estimation =
      [](const std::string& device, const ExtrinsicParameters& parameters) {
        return makePoseEstimation(device, parameters);
      };
  std::function<std::unique_ptr<PoseTracking>(const std::string& device, const std::vector<Camera>&, double deviation)>
      tracking = makePoseTracking;
};

/** \brief Poses that follow what the cameras see: all that the first frame tells, then frame by frame beside the fusion. A frame
 *  is fused with the poses of the frames before it, so that the result does not depend on who is faster. */
class LiveExtrinsics {
 public:
  /** \param device as of MethodOptions: with "auto" the CPU goes on where the GPU has failed, from the poses found by then
   *  \param warn gets one line when that happens; empty: it does not, as nobody would know */
  explicit LiveExtrinsics(const std::string& device, std::function<void(const std::string&)> warn = {},
                          PoseMakers make = {})
      : device_(device), warn_(std::move(warn)), make_(std::move(make)) {}

  /** \brief Puts the poses into the cameras of the next frame. Throws pcl::PCLException for one that contradicts itself, and InputError for
   *  a rig of one camera. */
  void place(RigFrame& frame);
  /** \brief The cameras that were found, by the frame before, to have moved. */
  const std::vector<CameraMotion>& moved() const { return moved_; }

 private:
  void begin(RigFrame& frame);
  void follow(RigFrame& frame);
  /** \brief Does it again on the CPU if the GPU fails and need not be used. */
  template <typename Action>
  void onEither(RigFrame& frame, const Action& action);

  std::string device_;
  std::function<void(const std::string&)> warn_;
  PoseMakers make_;
  std::unique_ptr<PoseTracking> tracking_;
  std::size_t updates_{0};
  std::vector<CameraMotion> moved_;
};

/** \brief "camera 'left' has moved by 51.2 mm and 1.04 degrees". */
std::string describe(const CameraMotion& motion, const std::vector<Camera>& cameras);

}  // namespace fuse_flow::io
