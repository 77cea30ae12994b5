#pragma once

#include "calibration/poses.h"

namespace fuse_flow::io {

/** \brief See makePoseEstimation(); where runsOnGpu(). */
std::unique_ptr<PoseEstimation> makeGpuPoseEstimation(const ExtrinsicParameters& parameters, unsigned int threads);

/** \brief See makePoseTracking(); where runsOnGpu(). */
std::unique_ptr<PoseTracking> makeGpuPoseTracking(const std::vector<Camera>& cameras, double deviation);

}  // namespace fuse_flow::io
