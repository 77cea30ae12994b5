#pragma once

#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/depth.h>

namespace fuse_flow {
namespace gpu {

/** \brief Small-hole fill, one pixel at a time. */
struct FillHoles {
  PixelGrid grid;
  PreprocessingParameters parameters;
  const float* measured;
  float* filled;
  float* q;  // 1 / filled as well, unless null

  FUSE_FLOW_HD float filledAt(const DeviceView& view, const PixelAddress& a, std::uint32_t index) const {
    const float z = measured[index];
    if (z > 0 || a.u >= view.model.intrinsics.width) return z;  // beyond the width: padding
    float patch[9];
    readPatch({&view, measured}, a.u, a.v, index, 1, patch);
    return filledDepth(parameters, patch);
  }

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = grid.addressOf(index);
    const DeviceView& view = grid.views[a.view];
    if (!view.present) return;
    const float z = filledAt(view, a, index);
    filled[index] = z;
    if (q != nullptr) q[index] = z > 0 ? 1.0f / z : 0.0f;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
