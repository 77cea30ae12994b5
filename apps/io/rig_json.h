#pragma once

#include <fuse_flow/camera.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief One entry of rig.json. */
struct RigCamera {
  Camera camera;
  /** \brief Metres per unit of its depth images. */
  float depth_scale{0.001f};
};

/** \brief Reads a rig's calibration; doc/formats.md describes the file. Throws InputError, naming file, camera, key,
 *  value and what is expected. */
std::vector<RigCamera> readRigJson(const std::string& path);

/** \brief Writes one, such that reading it gives the same numbers. Throws OutputError. */
void writeRigJson(const std::string& path, const std::vector<RigCamera>& cameras);

}  // namespace fuse_flow::io
