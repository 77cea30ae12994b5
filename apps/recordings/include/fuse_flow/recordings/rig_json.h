#pragma once

#include <fuse_flow/camera.h>

#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief One entry of rig.json. */
struct RigCamera {
  Camera camera;  ///< with its name, which is that of its folder
  /** \brief What one step of its confidence images is worth, so that 1 is certain; absent: the largest value of the file's type is 1. */
  std::optional<float> confidence_scale{};
};

/** \brief What rig.json says. */
struct RigDescription {
  std::vector<RigCamera> cameras;  ///< in the file's order
  /** \brief At which all cameras took their frames, Hz; 0.001 to 10^6. */
  std::optional<double> frames_per_second;
  /** \brief Of keys that mean nothing here, a line each. */
  std::vector<std::string> warnings{};
};

/** \brief Reads a rig's calibration; doc/reference/formats.md describes the file. Throws InputError, naming file, camera, key,
 *  value and what is expected. */
RigDescription readRigJson(const std::string& path);

/** \brief Writes one, such that reading it gives the same numbers. Throws OutputError. */
void writeRigJson(const std::string& path, const RigDescription& rig);

}  // namespace fuse_flow::io
