#include "stereo/gpu_stereo.h"

#include <fuse_flow/gpu/stereo/multi_view_stereo.h>

namespace fuse_flow::io {

std::unique_ptr<DepthEstimation> makeGpuDepthEstimation(const StereoParameters& parameters, unsigned int threads) {
  return std::make_unique<DepthEstimationOn<device::Thrust>>(parameters, threads);
}

}  // namespace fuse_flow::io
