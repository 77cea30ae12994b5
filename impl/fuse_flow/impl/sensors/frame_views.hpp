#pragma once

#include <fuse_flow/impl/host/parallel.hpp>
#include <fuse_flow/impl/sensors/preprocessing.hpp>
#include <fuse_flow/impl/sensors/rig_geometry.hpp>

namespace fuse_flow {
namespace host {

/** \brief The geometry and the depth maps of a frame, for the filters that work on their own. */
struct FrameViews {
  RigGeometry rig;
  std::vector<DepthMap> depths;

  void assign(const RigFrame& frame, const PreprocessingParameters& preprocessing, int threads) {
    rig.update(frame);
    depths.resize(frame.views.size());
    parallelFor(threads, frame.views.size(), [&](std::size_t i, int) {
      if (frame.views[i].missing()) {
        depths[i].clear();
      } else {
        makeDepthMap(preprocessing, rig[i], frame.views[i], depths[i]);
      }
    });
  }
};

}  // namespace host
}  // namespace fuse_flow
