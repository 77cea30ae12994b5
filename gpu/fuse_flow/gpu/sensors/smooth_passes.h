#pragma once

#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/gpu/sensors/smooth_depth_kernel.h>

namespace fuse_flow {
namespace gpu {

/** \brief All passes. \param maps to and fro between these: inverse depth in the first to begin with, in the end depth in that of
 *  the number of passes  \param pixels of all views, padding included */
inline void smoothDepth(Execution& run, const TileGrid& tiles, std::size_t pixels, const SmoothingParameters& smoothing,
                        DeviceBuffer<float> (&maps)[2]) {
  (void)pixels;
  for (int pass = 0; pass < smoothing.passes; ++pass) {
    const SmoothDepth step{tiles.pixels, smoothing, pass, maps[pass % 2].data(), maps[(pass + 1) % 2].data()};
#if FUSE_FLOW_CUDA
    run.launch("smoothDepthKernel", smoothDepthKernel, tiles.count, kTileThreads, step, tiles);
#else
    run.forEach(pixels, step);
#endif
  }
}

}  // namespace gpu
}  // namespace fuse_flow
