#include "calibration/poses.h"

#include "calibration/gpu_poses.h"
#include "calibration/poses_by.h"
#include "methods/gpu_method.h"

#include <fuse_flow/point_types.h>

namespace fuse_flow::io {

std::unique_ptr<PoseEstimation> makePoseEstimation(const std::string& device, const ExtrinsicParameters& parameters,
                                                   unsigned int threads) {
  if (runsOnGpu(device)) return makeGpuPoseEstimation(parameters, threads);
  return std::make_unique<PoseEstimationBy<ExtrinsicEstimation<PointFused>>>(parameters, threads);
}

std::unique_ptr<PoseTracking> makePoseTracking(const std::string& device, const std::vector<Camera>& cameras,
                                               double deviation) {
  if (runsOnGpu(device)) return makeGpuPoseTracking(cameras, deviation);
  return std::make_unique<PoseTrackingBy<ExtrinsicTracking<PointFused>>>(cameras, deviation);
}

}  // namespace fuse_flow::io
