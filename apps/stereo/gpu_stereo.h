#pragma once

#include "stereo/depth_estimation.h"

namespace fuse_flow::io {

/** \brief Where runsOnGpu(). Throws DeviceError. */
std::unique_ptr<DepthEstimation> makeGpuDepthEstimation(const StereoParameters& parameters, unsigned int threads);

}  // namespace fuse_flow::io
