#include "stereo/gpu_stereo.h"

#include <fuse_flow/gpu/runtime/system.h>
#include <fuse_flow/gpu/stereo/multi_view_stereo.h>

namespace fuse_flow::io {

namespace {

/** \brief Comes before what runs on the stream, which it must outlive. */
struct StereoStream {
  gpu::OwnStream stream;
};

/** \brief On a stream of its own: the frame before is fused meanwhile. */
class OnGpu : private StereoStream, public DepthEstimationOn<device::Thrust> {
 public:
  OnGpu(const StereoParameters& parameters, unsigned int threads) : DepthEstimationOn(parameters, threads) {
    stereo_.setStream(stream.get());
  }
};

}  // namespace

std::unique_ptr<DepthEstimation> makeGpuDepthEstimation(const StereoParameters& parameters, unsigned int threads) {
  return std::make_unique<OnGpu>(parameters, threads);
}

}  // namespace fuse_flow::io
