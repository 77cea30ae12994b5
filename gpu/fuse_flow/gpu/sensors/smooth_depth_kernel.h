#pragma once

#include <fuse_flow/gpu/sensors/smooth_depth.h>

#if FUSE_FLOW_CUDA

namespace fuse_flow {
namespace gpu {

/** \brief SmoothDepth, one block a tile. */
static __global__ void __launch_bounds__(kTileThreads) smoothDepthKernel(const SmoothDepth step, const TileGrid tiles) {
  forEachPixelOfTileInView(tiles, [&step](const DeviceView& view, const PixelAddress& a, std::uint32_t index) {
    step.out[index] = step.smoothed(view, a, index);
  });
}

}  // namespace gpu
}  // namespace fuse_flow

#endif
