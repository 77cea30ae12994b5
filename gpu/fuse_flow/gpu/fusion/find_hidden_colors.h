#pragma once

#include <fuse_flow/gpu/runtime/execution.h>
#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/gpu/sensors/frame_views.h>

namespace fuse_flow {
namespace gpu {

/** \brief What lies nearest to the colour cameras that stand beside their depth cameras, pixel of depth by pixel. */
struct AddToColorDepth {
  PixelGrid grid;
  /** \brief D^r of eq. 8. */
  const float* z;
  /** \brief The cells of all views, and where they are. */
  const std::uint32_t* read;
  std::uint32_t* write;

  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = grid.addressOf(index);
    const DeviceView& view = grid.views[a.view];
    if (view.color_depth.nearest == nullptr || a.u >= view.model.intrinsics.width || !(z[index] > 0)) return;
    const ColorPixel at = colorPixel(view.model, view.ray(a.u, a.v), z[index]);
    if (!at.known) return;
    std::uint32_t* const cells = write + (view.color_depth.nearest - read);
    view.color_depth.add(at.pixel, at.z,
                         [&](std::size_t cell, std::uint32_t bits) { atomicMinTo(cells + cell, bits); });
  }
};

/** \brief Fills the cells of all views that have any, before colours are read. \param z D^r of eq. 8 */
inline void findHiddenColors(Execution& run, FrameViews& views, const float* z) {
  std::uint32_t* const cells = views.colorDepthCells();
  if (views.colorDepthCellCount() == 0) return;
  run.fill(cells, views.colorDepthCellCount(), ColorDepth::kNothing & 0xff);
  run.forEach(views.pixels(), AddToColorDepth{views.grid(), z, cells, cells});
}

}  // namespace gpu
}  // namespace fuse_flow
