#pragma once

#include "simulation/simulator.h"

#include <cstddef>
#include <string>
#include <vector>

namespace fuse_flow::simulation {

/** \brief The exact surfaces and camera poses behind a simulated recording. In the recording's folder: truth/rig.json, the
 *  true poses; truth/simulation.json, how it was made, with the objects' materials; truth/fixed.ply and, unless nothing moves,
 *  truth/moving/NNNNNN.ply: binary triangle meshes, vertices with x, y, z, nx, ny, nz, rest_x, rest_y, rest_z, where they move
 *  velocity_x, velocity_y, velocity_z (m/s), and red, green, blue (under the scene's light) and object, a number into the
 *  materials. */
class Truth {
 public:
  /** \brief Throws io::InputError if the folder has no truth or a damaged one. */
  explicit Truth(const std::string& recording_folder);

  /** \brief Whether a folder has one. */
  static bool isIn(const std::string& recording_folder);
  /** \brief The files that lack in its folder truth; none if it has no such folder, or a whole one. */
  static std::vector<std::string> missingIn(const std::string& recording_folder);

  /** \brief The surfaces of one frame; valid until the next call. */
  const RayScene& frame(std::size_t frame);
  const std::vector<Camera>& cameras() const { return cameras_; }
  /** \brief Whether objects have parts; those of recordings of FUSE-Flow 0.1 have none, and no velocities. */
  bool namesParts() const { return names_parts_; }
  /** \brief What the sensors can measure, metres. */
  float minRange() const { return min_range_; }
  float maxRange() const { return max_range_; }

 private:
  static bool hasFolder(const std::string& recording_folder);
  std::string folder_;
  std::vector<Camera> cameras_;
  std::vector<Object> fixed_;  // materials only, until the meshes are read
  std::vector<Object> moving_;
  bool names_parts_{true};
  float min_range_{0};
  float max_range_{0};
  RayScene scene_;
  std::size_t loaded_{static_cast<std::size_t>(-1)};
};

/** \brief Writes what is the same for all frames. Throws io::OutputError. */
void writeTruth(const std::string& recording_folder, const Simulator& simulator);

/** \brief Writes the moving surfaces of one frame, if there are any. Throws io::OutputError. */
void writeTruth(const std::string& recording_folder, const Simulator& simulator, std::size_t frame);

}  // namespace fuse_flow::simulation
