#pragma once

#include <fuse_flow/gpu/sensors/device_view.h>
#include <fuse_flow/math/representatives.h>

namespace fuse_flow {
namespace gpu {

/** \brief Colour and normal of the measurements behind a fused point. */
struct Appearance {
  PixelGrid grid;
  const float* z;

  FUSE_FLOW_HD ViewColor color(const PixelAddress& a) const {
    const DeviceView& view = grid.views[a.view];
    if (!view.color) return {};
    if (!view.model.own_color_camera) return pixelColor(view.color, a.u, a.v);
    return viewColor(view.model, view.color, view.color_depth, a.u, a.v, view.ray(a.u, a.v), z[view.indexOf(a.u, a.v)]);
  }

  FUSE_FLOW_HD Vec3 normal(const PixelAddress& a) const {
    const DeviceView& view = grid.views[a.view];
    return surfaceNormal(view.model, DepthMapOfView{&view, z}, a.u, a.v);
  }
};

/** \brief Writes the fused points that stay, one after the other, as points of the user's type. \tparam Layout see PointLayout */
template <typename Layout>
struct WritePoints {
  Layout layout;
  Appearance appearance;
  bool with_normals;
  bool weight_in_intensity;
  const FusedPoint* fused;
  const float* weights;
  const std::uint32_t* view_counts;
  /** \brief PointCameras::mask() of each; where Layout has_camera_mask. */
  const std::uint64_t* cameras;
  const std::uint32_t* staying;
  typename Layout::Words* output;

  FUSE_FLOW_HD void operator()(std::uint32_t k) const {
    FusedPoint point = fused[staying[k]];
    point.weight = weights[staying[k]];
    if (Layout::has_view_count) point.views = view_counts[staying[k]];
    ColorMean color;
    NormalMean normal;
    for (int s = 0; s < kRepresentatives; ++s) {
      if (s >= static_cast<int>(point.count) || !(Layout::shows_color || (Layout::has_normal && with_normals)))
        continue;
      const PixelAddress a = appearance.grid.addressOf(point.source[s]);
      if (Layout::shows_color) color.add(point.share[s], appearance.color(a));
      if (Layout::has_normal && with_normals) normal.add(point.share[s], appearance.normal(a));
    }
    const std::uint64_t mask = Layout::has_camera_mask ? cameras[staying[k]] : 0;
    const float intensity = weight_in_intensity ? point.weight : luminance(color.mean());
    typename Layout::Words w = layout.words(point, mask, color.mean(), intensity);
    if (Layout::has_normal && with_normals) Layout::setNormal(w, normal.meanOrNan());
    output[k] = w;
  }
};

}  // namespace gpu
}  // namespace fuse_flow
