#pragma once

#include <fuse_flow/impl/sensors/depth_map.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/math/agreement.h>
#include <fuse_flow/math/consistency.h>

#include <cstddef>
#include <vector>

namespace fuse_flow {
namespace host {

/** \brief What too few other views measure, too, weighs nothing any more. \param depths D^r of all views  \param views whose confidence says where
 *  there is no depth  \param i the view of row v  \param weights of the row's pixels */
inline void keepAgreed(const AgreementParameters& p, const RigGeometry& rig, const std::vector<DepthMap>& depths,
                       const std::vector<DepthView>& views, std::size_t i, int v, float* weights) {
  const ViewGeometry& view = rig[i];
  const std::vector<std::uint32_t>& others = view.neighbours;
  const auto model = [&](int k) -> const ViewModel* {
    const std::uint32_t j = others[static_cast<std::size_t>(k)];
    return depths[j].empty() ? nullptr : &rig[j];
  };
  const auto depth = [&](int k, int u_j, int v_j) {
    const std::uint32_t j = others[static_cast<std::size_t>(k)];
    return confidenceAt(views[j].confidence, u_j, v_j) > 0 ? depths[j].row(v_j)[u_j] : 0.0f;
  };
  const float* z = depths[i].row(v);
  for (int u = 0; u < depths[i].width(); ++u) {
    if (!(weights[u] > 0)) continue;
    const Vec3 p_W = view.T_world_camera * pointOnRay(view.ray(u, v), z[u]);
    if (!isAgreed(p, view, {static_cast<float>(u), static_cast<float>(v)}, z[u], p_W, static_cast<int>(others.size()),
                  model, depth))
      weights[u] = 0;
  }
}

}  // namespace host
}  // namespace fuse_flow
