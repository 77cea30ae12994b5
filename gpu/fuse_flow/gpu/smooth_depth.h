#pragma once

#include <fuse_flow/gpu/tiles.h>
#include <fuse_flow/math/smoothing.h>

namespace fuse_flow {
namespace gpu {

/** \brief One pass of the smoothing at one pixel. The last pass writes depth instead of inverse depth. */
struct SmoothDepth {
  PixelGrid grid;
  SmoothingParameters smoothing;
  ConfidenceParameters confidence;
  int pass;
  const float* q;
  float* out;

  FUSE_FLOW_HD float smoothed(const PixelAddress& a, std::uint32_t index) const {
    const DeviceView& view = grid.views[a.view];
    const Intrinsics& K = view.model.intrinsics;
    if (a.u >= K.width) return 0.0f;  // padding
    const float centre = q[index];
    if (!(centre > 0)) return 0.0f;
    const int step = smoothingStep(pass);
    float patch[9];
    if ((a.u >= step) & (a.v >= step) & (a.u < K.width - step) & (a.v < K.height - step)) {
      const float* above = q + index - static_cast<std::uint32_t>(step) * view.pitch;
      const float* here = q + index;
      const float* below = q + index + static_cast<std::uint32_t>(step) * view.pitch;
      for (int k = 0; k < 3; ++k) {
        patch[k] = above[(k - 1) * step];
        patch[3 + k] = here[(k - 1) * step];
        patch[6 + k] = below[(k - 1) * step];
      }
    } else {
      const DepthMapOfView map{&view, q};
      for (int k = 0; k < 9; ++k) patch[k] = map.depth(a.u + (k % 3 - 1) * step, a.v + (k / 3 - 1) * step);
    }
    const float tolerance = smoothingTolerance(smoothing, pass, view.noise_scale);
    const float result = smoothedInverseDepth(patch, tolerance * inverseDepthNoise(confidence, centre));
    if (pass != smoothing.passes - 1) return result;
    return result > 0 ? 1.0f / result : 0.0f;
  }

  FUSE_FLOW_HD void operator()(std::uint32_t index) const { out[index] = smoothed(grid.addressOf(index), index); }
};

#if FUSE_FLOW_CUDA
static __global__ void __launch_bounds__(kTileThreads) smoothDepthKernel(const SmoothDepth step, const TileGrid tiles) {
  PixelAddress a;
  if (!pixelOfTile(tiles, a)) return;
  const std::uint32_t index = step.grid.views[a.view].indexOf(a.u, a.v);
  step.out[index] = step.smoothed(a, index);
}
#endif

}  // namespace gpu
}  // namespace fuse_flow
