#pragma once

#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/gpu/sensors/smooth_depth_kernel.h>

namespace fuse_flow {
namespace gpu {

/** \brief All passes. \param maps of smoothingMap(): inverse depth in the first to begin with, in the end depth in that of
 *  smoothingPasses(); the third is allocated here, and only for twicing  \param pixels of all views, padding included */
inline void smoothDepth(Execution& run, const TileGrid& tiles, std::size_t pixels, const SmoothingParameters& smoothing,
                        DeviceBuffer<float> (&maps)[3]) {
  if (twicingPasses(smoothing) > 0) maps[2].resize(pixels);
  for (int pass = 0; pass < smoothingPasses(smoothing); ++pass) {
    const SmoothDepth step{tiles.pixels,
                           smoothing,
                           pass,
                           maps[smoothingMap(smoothing, pass)].data(),
                           maps[smoothingMap(smoothing, pass + 1)].data(),
                           maps[smoothingMap(smoothing, smoothing.passes)].data()};
#if FUSE_FLOW_CUDA
    run.launch("smoothDepthKernel", smoothDepthKernel, tiles.count, kTileThreads, step, tiles);
#else
    run.forEach(pixels, step);
#endif
  }
}

}  // namespace gpu
}  // namespace fuse_flow
