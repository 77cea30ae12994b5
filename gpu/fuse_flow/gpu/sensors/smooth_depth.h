#pragma once

#include <fuse_flow/gpu/sensors/tiles.h>
#include <fuse_flow/math/smoothing.h>

namespace fuse_flow {
namespace gpu {

/** \brief One pass of the smoothing at one pixel. The last pass writes depth instead of inverse depth. */
struct SmoothDepth {
  PixelGrid grid;
  SmoothingParameters smoothing;
  int pass;
  const float* q;
  float* out;
  /** \brief After smoothing.passes passes. */
  const float* before_twicing;

  FUSE_FLOW_HD float smoothed(const DeviceView& view, const PixelAddress& a, std::uint32_t index) const {
    if (a.u >= view.model.intrinsics.width) return 0.0f;  // padding
    const float centre = q[index];
    if (!(centre > 0)) return 0.0f;
    float patch[9];
    readPatch({&view, q}, a.u, a.v, index, smoothingStep(smoothing, pass, view.noise.level()), patch);
    const float tolerance = smoothingTolerance(smoothing, pass, view.noise.scale);
    const float of_model = inverseDepthNoise(view.noise.model, centre);
    float result = smoothedInverseDepth(patch, tolerance * of_model);
    if (pass != smoothingPasses(smoothing) - 1) return result;
    if (pass >= smoothing.passes) {
      const DepthMapOfView before{&view, before_twicing};
      const float cross[5] = {before_twicing[index], before.depth(a.u - 1, a.v), before.depth(a.u + 1, a.v),
                              before.depth(a.u, a.v - 1), before.depth(a.u, a.v + 1)};
      result = twicedInverseDepth(smoothing, cross, result, view.noise.scale * of_model);
    }
    return result > 0 ? 1.0f / result : 0.0f;
  }

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = grid.addressOf(index);
    if (grid.views[a.view].present) out[index] = smoothed(grid.views[a.view], a, index);
  }
};

}  // namespace gpu
}  // namespace fuse_flow
