#pragma once

#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>

namespace fuse_flow {
namespace host {

/** \brief What a view measured, as the maths of surfaces asks for it; gpu::DepthMapOfView's counterpart. */
struct DepthSurface {
  const DepthMap& map;
  const ViewGeometry& view;

  /** \brief Metres; 0 where there is no measurement, and up to DepthMap::kBorder pixels beyond the image. */
  float depth(int u, int v) const { return map.row(v)[u]; }
  Ray ray(int u, int v) const { return view.ray(u, v); }
};

}  // namespace host
}  // namespace fuse_flow
