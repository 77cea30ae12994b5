#pragma once

#include "simulation/ray_scene.h"

#include <fuse_flow/rig_frame.h>

#include <cstddef>
#include <string>
#include <vector>

namespace fuse_flow::simulation {

/** \brief The exact surfaces and camera poses behind a simulated recording. On disk, in the recording's folder:
 *  truth/rig.json (true poses), truth/fixed.ply, truth/moving/NNNNNN.ply (absent in a static scene). The PLY files are
 *  binary meshes with x, y, z, nx, ny, nz, red, green, blue (the colour under the scene's light) and faces. */
class Truth {
 public:
  /** \brief Throws io::InputError if the folder has no truth. */
  explicit Truth(const std::string& recording_folder);

  /** \brief The surfaces of one frame; valid until the next call. */
  const RayScene& frame(std::size_t frame);
  const std::vector<Camera>& cameras() const { return cameras_; }

 private:
  std::string folder_;
  std::vector<Camera> cameras_;
  RayScene scene_;
  std::size_t loaded_{static_cast<std::size_t>(-1)};
};

}  // namespace fuse_flow::simulation
