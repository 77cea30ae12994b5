#pragma once

#include <fuse_flow/rig_frame.h>

#include <cmath>
#include <cstdint>

namespace fuse_flow::io {

/** \brief Depth of a pixel, metres; 0 where there is none. */
inline float depthAt(const Camera& camera, const DepthView& view, int u, int v) {
  if (view.depth32) {
    const float z = view.depth32.row(v)[u];
    return std::isfinite(z) && z > 0 ? z : 0.0f;
  }
  const std::uint16_t raw = view.depth16.row(v)[u];
  return raw == 65535 ? 0.0f : camera.depth_scale * static_cast<float>(raw);
}

}  // namespace fuse_flow::io
