#include "calibration/gpu_poses.h"
#include "calibration/poses_by.h"

#include <fuse_flow/gpu/calibration/extrinsic_tracking.h>
#include <fuse_flow/point_types.h>

// All of them, so that a build where there is nvcc shows that they compile.
template class fuse_flow::ExtrinsicEstimation<fuse_flow::PointFused, fuse_flow::device::Thrust>;
template class fuse_flow::ExtrinsicTracking<fuse_flow::PointFused, fuse_flow::device::Thrust>;

namespace fuse_flow::io {

std::unique_ptr<PoseEstimation> makeGpuPoseEstimation(const ExtrinsicParameters& parameters, unsigned int threads) {
  return std::make_unique<PoseEstimationBy<ExtrinsicEstimation<PointFused, device::Thrust>>>(parameters, threads);
}

std::unique_ptr<PoseTracking> makeGpuPoseTracking(const std::vector<Camera>& cameras, double deviation) {
  return std::make_unique<PoseTrackingBy<ExtrinsicTracking<PointFused, device::Thrust>>>(cameras, deviation);
}

}  // namespace fuse_flow::io
