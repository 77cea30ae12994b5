#pragma once

#include <fuse_flow/distributed/block_owners.h>
#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>
#include <fuse_flow/math/smoothing.h>

#include <algorithm>
#include <vector>

namespace fuse_flow {
namespace distributed {

/** \brief Of each view, the views whose points may ask it, itself among them: eq. 7 looks no farther. A cell's points ask along the list of
 *  one of the views that have points in it. \param origin whose view each is; −1: nobody's */
inline std::vector<ViewSet> askersOfViews(const host::RigGeometry& rig, const std::vector<int>& origin,
                                          const FuseFlowParameters& parameters) {
  std::vector<ViewSet> askers(rig.size(), ViewSet(rig.size()));
  for (std::size_t i = 0; i < rig.size(); ++i) {
    askers[i].add(i);
    int candidates = 0;
    for (const std::uint32_t j : rig[i].neighbours) {
      if (origin[j] < 0) continue;
      if (++candidates > parameters.consistency.max_candidates || !parameters.use_distance_consistency) break;
      askers[j].add(i);
    }
  }
  return askers;
}

/** \brief Pixels around a point that its fusion reads: for silhouettes, normals and between pixels. */
inline int lookingMargin(const FuseFlowParameters& parameters) {
  return std::max(parameters.consistency.silhouette_radius, kWideNormalSpacing) + 2;
}

}  // namespace distributed
}  // namespace fuse_flow
