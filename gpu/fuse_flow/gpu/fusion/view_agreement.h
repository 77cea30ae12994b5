#pragma once

#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/gpu/sensors/tiles.h>
#include <fuse_flow/math/agreement.h>
#include <fuse_flow/math/consistency.h>

namespace fuse_flow {
namespace gpu {

/** \brief What too few other views measure, too, weighs nothing any more; see isAgreed(). */
struct KeepAgreed {
  PixelGrid grid;
  /** \brief D^r of eq. 8. */
  const float* z;
  AgreementParameters parameters;
  /** \brief Of all pixels; 0 stays 0. */
  float* weights;

  FUSE_FLOW_HD void keep(const DeviceView& view, const PixelAddress& a, std::uint32_t index) const {
    if (!(weights[index] > 0)) return;
    const DeviceView* views = grid.views;
    const float* depths = z;
    const auto model = [&view, views](int k) { return &views[view.neighbours[k]].model; };
    const auto depth = [&view, views, depths](int k, int u, int v) {
      const DeviceView& other = views[view.neighbours[k]];
      return confidenceAt(other.confidence, u, v) > 0 ? depths[other.indexOf(u, v)] : 0.0f;
    };
    const Vec3 p_W = view.model.T_world_camera * pointOnRay(view.ray(a.u, a.v), depths[index]);
    const bool agreed = isAgreed(parameters, view.model, {static_cast<float>(a.u), static_cast<float>(a.v)},
                                 depths[index], p_W, static_cast<int>(view.neighbour_count), model, depth);
    if (!agreed) weights[index] = 0;
  }
  FUSE_FLOW_HD void operator()(std::uint32_t index) const {
    const PixelAddress a = grid.addressOf(index);
    keep(grid.views[a.view], a, index);
  }
};

#if FUSE_FLOW_CUDA
/** \brief KeepAgreed, one block a tile. */
static __global__ void __launch_bounds__(kTileThreads) keepAgreedKernel(const KeepAgreed step, const TileGrid tiles) {
  forEachPixelOfTileInView(tiles, [&step](const DeviceView& view, const PixelAddress& a, std::uint32_t index) {
    step.keep(view, a, index);
  });
}
#endif

}  // namespace gpu
}  // namespace fuse_flow
