#pragma once

#include <fuse_flow/impl/host/rig_geometry.hpp>

namespace fuse_flow {
namespace host {

/** \brief Colour, channels 0 … 255, of the depth pixel (u, v) with depth z; black where there is none. With a colour
 *  camera of its own, the point is projected into that, to the nearest pixel of the border where it just misses. */
inline Vec3 viewColor(const Camera& camera, const ViewGeometry& geometry, const ImageView<Rgb8>& image, int u, int v,
                      float z) {
  if (!image) return {};
  if (camera.color) {
    const Vec3 p_C = geometry.T_color_depth * pointOnRay(geometry.ray(u, v), z);
    if (!(p_C.z > 0)) return {};
    const Pixel pixel = project(camera.color->intrinsics, p_C);
    u = static_cast<int>(std::clamp(pixel.u + 0.5f, 0.0f, static_cast<float>(image.width - 1)));
    v = static_cast<int>(std::clamp(pixel.v + 0.5f, 0.0f, static_cast<float>(image.height - 1)));
  }
  const Rgb8 c = image.row(v)[u];
  return {static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b)};
}

}  // namespace host
}  // namespace fuse_flow
