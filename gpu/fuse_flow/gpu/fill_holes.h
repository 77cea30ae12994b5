#pragma once

#include <fuse_flow/gpu/device_view.h>
#include <fuse_flow/math/depth.h>

namespace fuse_flow {
namespace gpu {

/** \brief Small-hole fill, one pixel at a time. */
struct FillHoles {
  PixelGrid grid;
  PreprocessingParameters parameters;
  const float* measured;
  float* filled;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const float z = measured[index];
    const PixelAddress a = grid.addressOf(index);
    const DeviceView& view = grid.views[a.view];
    if (z > 0 || a.u >= view.model.intrinsics.width) {  // beyond the width: padding
      filled[index] = z;
      return;
    }
    const DepthMapOfView map{&view, measured};
    float patch[9];
    for (int k = 0; k < 9; ++k) patch[k] = map.depth(a.u + k % 3 - 1, a.v + k / 3 - 1);
    filled[index] = filledDepth(parameters, patch);
  }
};

}  // namespace gpu
}  // namespace fuse_flow
