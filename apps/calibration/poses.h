#pragma once

#include <fuse_flow/calibration/extrinsic_parameters.h>
#include <fuse_flow/calibration/extrinsic_result.h>
#include <fuse_flow/rig_frame.h>

#include <memory>
#include <string>
#include <vector>

namespace fuse_flow {
struct TrackedPoses;
}

namespace fuse_flow::io {

/** \brief ExtrinsicEstimation, on the CPU or on a GPU. */
class PoseEstimation {
 public:
  virtual ~PoseEstimation() = default;
  virtual void addFrame(const RigFrame& frame) = 0;
  virtual ExtrinsicResult estimate(const std::vector<Eigen::Isometry3d>& initial) = 0;
};

/** \brief ExtrinsicTracking, on the CPU or on a GPU. */
class PoseTracking {
 public:
  virtual ~PoseTracking() = default;
  virtual bool push(const RigFrame& frame) = 0;
  virtual void finish() = 0;
  virtual std::shared_ptr<const TrackedPoses> poses() const = 0;
  virtual void apply(RigFrame& frame) const = 0;
};

/** \param device as of MethodOptions; throws OptionError, beginning with --device gpu, if there is none
 *  \param parameters as of the class  \param threads 0: one per core */
std::unique_ptr<PoseEstimation> makePoseEstimation(const std::string& device,
                                                   const ExtrinsicParameters& parameters = {},
                                                   unsigned int threads = 0);

/** \param device as above  \param cameras with the poses to begin at  \param deviation of those, metres */
std::unique_ptr<PoseTracking> makePoseTracking(const std::string& device, const std::vector<Camera>& cameras,
                                               double deviation);

}  // namespace fuse_flow::io
