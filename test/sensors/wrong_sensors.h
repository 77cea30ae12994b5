#pragma once

/** \file
 *  \brief Depth cameras that measure wrong. */

#include "../scenes.h"
#include "simulation/depth_distortion.h"

namespace scenes {

/** \brief What a sensor that needs a correction makes of an exact image. */
inline void mismeasure(fuse_flow::io::FloatImage& depth, const fuse_flow::DepthCorrection& correction) {
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u)
      depth.at(u, v) = static_cast<float>(fuse_flow::simulation::mismeasured(
          static_cast<double>(depth.at(u, v)), correction.at(u, v, depth.width, depth.height)));
}

/** \brief Makes all cameras measure wrong, and say how. */
inline void distort(Scene& scene, const fuse_flow::DepthCorrection& correction) {
  for (std::size_t i = 0; i < scene.depth.size(); ++i) {
    mismeasure(scene.depth[i], correction);
    scene.rig.cameras[i].depth_correction = correction;
  }
  scene.attach();
}

}  // namespace scenes
