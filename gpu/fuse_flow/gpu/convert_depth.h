#pragma once

#include <fuse_flow/gpu/device_view.h>
#include <fuse_flow/math/depth.h>
#include <fuse_flow/preprocessing.h>

namespace fuse_flow {
namespace gpu {

/** \brief Raw depth to metres, one pixel. */
struct ConvertDepth {
  PixelGrid grid;
  float min_range, max_range;
  float* z;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = grid.addressOf(index);
    const DeviceView& view = grid.views[a.view];
    float metre = 0;
    if (a.u < view.model.intrinsics.width) {
      metre = view.depth16 ? metres(view.depth16.row(a.v)[a.u], view.depth_scale, min_range, max_range)
                           : metres(view.depth32.row(a.v)[a.u], min_range, max_range);
    }
    z[index] = metre;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
